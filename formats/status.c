#include "airlight/status.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

al_status al_fail(al_error *error, al_status status, const char *format, ...)
{
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(error->message, sizeof error->message, format, arguments);
        va_end(arguments);
        error->status = status;
    }
    return status;
}

al_status al_fail_errno(al_error *error, const char *path, const char *action)
{
    int code = errno;
    al_status status = code == ENOENT || code == EISDIR || code == ENOTDIR ? AL_BAD_INPUT : AL_IO;
    return al_fail(error, status, "%s: cannot %s: %s", path, action, strerror(code));
}
