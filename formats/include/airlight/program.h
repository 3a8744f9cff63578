/* What every airlight program shares: options, help, messages, progress. Programs only; libraries never print. */
#ifndef AIRLIGHT_PROGRAM_H
#define AIRLIGHT_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum al_option_kind {
    AL_OPTION_FLAG,   /* bool * */
    AL_OPTION_STRING, /* const char ** */
    AL_OPTION_INT,    /* int * within [minimum, maximum] */
    AL_OPTION_REAL,   /* double * within [minimum, maximum] */
    AL_OPTION_LIST,   /* al_option_list *: may be repeated */
    AL_OPTION_SIZE    /* int[2]: WxH, each within [minimum, maximum] */
} al_option_kind;

enum { AL_OPTION_LIST_LIMIT = 64 };
typedef struct al_option_list {
    const char *values[AL_OPTION_LIST_LIMIT];
    int count;
} al_option_list;

typedef struct al_option {
    const char *name;     /* "--size" or "-o" */
    const char *argument; /* "WxH"; NULL for a flag */
    al_option_kind kind;
    void *value;
    const char *help;
    double minimum, maximum; /* for numbers */
} al_option;

typedef struct al_program {
    const char *name;       /* "airlight-bake" */
    const char *usage;      /* "SCENE.json -o DIR [options]" */
    const char *summary;    /* what it does, one paragraph */
    const al_option *options;
    size_t option_count;
    bool quiet, verbose; /* filled by the parser */
} al_program;

/* Parses; --help, --version, --quiet, --verbose are handled for every program. Returns -1 to go on, or the
 * exit code to end with (a message was printed). Positional arguments: at least `minimum`, at most `limit`. */
int al_program_parse(al_program *program, int argc, char **argv, const char **positionals, size_t minimum,
                     size_t limit, size_t *positional_count);
/* Prints "NAME: message" on standard error, as one line whatever the message holds, and returns the exit code. */
int al_program_fail(const al_program *program, const al_error *error);
/* For the end of main: `code`, or what failed when results did not reach standard output. */
int al_program_end(const al_program *program, int code);
/* AL_USAGE when `path`, the value of `option`, does not end in `ending` (".png") with a name before it. */
al_status al_program_check_ending(const char *option, const char *path, const char *ending, al_error *error);
/* "NAME: message" on standard error, as one line, unless --quiet. */
void al_program_say(const al_program *program, const char *format, ...) AL_PRINTF(2, 3);

/* Before the first thread starts: from then on Ctrl-C and SIGTERM only make al_program_cancelled true, which long
 * steps look at. */
void al_program_catch_signals(void);
bool al_program_cancelled(void);

/* Progress of one step on standard error: a bar with rate and time left on a terminal, plain lines at most
 * every few seconds else. Nothing with --quiet. Shape fits callbacks: returns true when cancelled. */
typedef struct al_progress {
    const al_program *program;
    const char *step;
    double started_s, printed_s;
} al_progress;
void al_progress_begin(al_progress *progress, const al_program *program, const char *step);
bool al_progress_update(al_progress *progress, double done, double total);
void al_progress_end(al_progress *progress);

double al_program_seconds(void); /* monotonic clock */

#ifdef __cplusplus
}
#endif
#endif
