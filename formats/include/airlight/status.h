/* Results and errors of every airlight library call.
 *
 * A function that can fail returns al_status and takes `al_error *error` last. On failure its other
 * out-parameters are NULL or zero, nothing leaks, and `error` (may be NULL) holds one line that says
 * which file, where in it, what is wrong and what would be right. Statuses are the programs' exit codes.
 * Thread safety: no global state; one al_error per thread. */
#ifndef AIRLIGHT_STATUS_H
#define AIRLIGHT_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum al_status {
    AL_OK = 0,
    AL_CHECK_FAILED = 1, /* the check or comparison says no */
    AL_USAGE = 2,        /* wrong usage */
    AL_BAD_INPUT = 3,    /* a file, scene or asset is not what it should be */
    AL_IO = 4,           /* input, output or memory failed */
    AL_NO_DEVICE = 5,    /* no usable OpenCL device or OpenGL context */
    AL_CANCELLED = 130   /* the user stopped it */
} al_status;

enum { AL_ERROR_SIZE = 2048 };

typedef struct al_error {
    al_status status;
    char message[AL_ERROR_SIZE]; /* one line without its newline, always terminated */
} al_error;

#if defined(__GNUC__)
#define AL_PRINTF(format_index, first_index) __attribute__((format(printf, format_index, first_index)))
#else
#define AL_PRINTF(format_index, first_index)
#endif

/* Fills `error` (ignored when NULL) and returns `status`, so that callers write `return al_fail(...)`. */
al_status al_fail(al_error *error, al_status status, const char *format, ...) AL_PRINTF(3, 4);

/* The same for a failed system call on `path`: adds what errno says. Status AL_IO, or AL_BAD_INPUT for a
 * file that does not exist or is a folder. */
al_status al_fail_errno(al_error *error, const char *path, const char *action);

#ifdef __cplusplus
}
#endif
#endif
