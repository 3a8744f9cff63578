#include "beside.h"

#include <string.h>
#include <unistd.h>

enum { NAME_LIMIT = 64 };

al_status al_find_beside(const char *name, char path[PATH_MAX], al_error *error)
{
    ssize_t size = readlink("/proc/self/exe", path, PATH_MAX - NAME_LIMIT - 1);
    if (size <= 0) return al_fail_errno(error, "/proc/self/exe", "find the running program in");
    path[size] = 0;
    strcpy(strrchr(path, '/') + 1, name);
    return AL_OK;
}
