#include "beside.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

al_status al_find_beside(const char *name, char path[PATH_MAX], al_error *error)
{
    char program[PATH_MAX];
    ssize_t size = readlink("/proc/self/exe", program, sizeof program - 1);
    if (size <= 0) return al_fail_errno(error, "/proc/self/exe", "find the running program in");
    program[size] = 0;
    *strrchr(program, '/') = 0;
    return snprintf(path, PATH_MAX, "%s/%s", program, name) < PATH_MAX
               ? AL_OK
               : al_fail(error, AL_IO, "%s: its path from the running program is too long; install in a shorter one", name);
}
