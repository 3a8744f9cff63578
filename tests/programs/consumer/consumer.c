/* A host outside the project: uses one function of each installed library. */
#include <stdio.h>
#include <string.h>

#include <airlight/container.h>
#include <airlight/runtime.h>

int main(void)
{
    al_file *file = NULL;
    al_error error;
    if (al_file_open("missing.air", NULL, &file, &error) != AL_BAD_INPUT || file) return 1;
    if (strcmp(al_pass_name(AL_PASS_COMPOSITE), "composite")) return 1;
    printf("%s\n", error.message);
    return 0;
}
