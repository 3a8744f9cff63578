#define _POSIX_C_SOURCE 200809L
#include "airlight/program.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Names of files and options may hold line ends and escape sequences; a message may not. */
static void print_line(const al_program *program, const char *message, const char *tail)
{
    fprintf(stderr, "%s: ", program->name);
    for (const char *c = message; *c; c++) fputc((unsigned char)*c < ' ' || *c == 127 ? '?' : *c, stderr);
    fprintf(stderr, "%s\n", tail);
}

AL_PRINTF(2, 3)
static int usage_error(const al_program *program, const char *format, ...)
{
    char message[AL_ERROR_SIZE], tail[128];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    snprintf(tail, sizeof tail, "; see %s --help", program->name);
    print_line(program, message, tail);
    return AL_USAGE;
}

static void print_option(const char *name, const char *argument, const char *help)
{
    char left[64];
    snprintf(left, sizeof left, "%s%s%s", name, argument ? " " : "", argument ? argument : "");
    printf("  %-26s %s\n", left, help);
}

static void print_help(const al_program *program)
{
    printf("usage: %s %s\n\n%s\n\noptions:\n", program->name, program->usage, program->summary);
    for (size_t i = 0; i < program->option_count; i++)
        print_option(program->options[i].name, program->options[i].argument, program->options[i].help);
    print_option("--quiet", NULL, "say nothing but errors and results");
    print_option("--verbose", NULL, "say more, whole build logs included");
    print_option("--help", NULL, "this text");
    print_option("--version", NULL, "name and version");
    printf("\nexit codes: 0 good, 1 the check says no, 2 wrong usage, 3 bad input, 4 input/output failed,\n"
           "            5 no usable device or context, 130 cancelled\n");
}

static bool parse_real(const char *text, double *value)
{
    char *end;
    errno = 0;
    *value = strtod(text, &end);
    return end != text && *end == 0 && errno == 0 && isfinite(*value);
}

static bool in_range(const al_option *option, double value)
{
    return option->minimum == option->maximum || (value >= option->minimum && value <= option->maximum);
}

static int range_error(const al_program *program, const al_option *option, const char *text)
{
    char expected[AL_ERROR_SIZE];
    const char *what = option->kind == AL_OPTION_REAL   ? "a number"
                       : option->kind == AL_OPTION_SIZE ? "WIDTHxHEIGHT, each"
                                                        : "a whole number";
    if (option->minimum == option->maximum)
        snprintf(expected, sizeof expected, "takes %s, not '%s'", what, text);
    else
        snprintf(expected, sizeof expected, "takes %s from %.10g to %.10g, not '%s'", what, option->minimum,
                 option->maximum, text);
    return usage_error(program, "%s %s", option->name, expected);
}

static int set_value(const al_program *program, const al_option *option, const char *text)
{
    double value = 0, second = 0;
    switch (option->kind) {
    case AL_OPTION_FLAG:
        *(bool *)option->value = true;
        return -1;
    case AL_OPTION_STRING:
        if (!*text) return usage_error(program, "%s needs %s, not ''", option->name, option->argument);
        *(const char **)option->value = text;
        return -1;
    case AL_OPTION_LIST: {
        al_option_list *list = option->value;
        if (list->count == AL_OPTION_LIST_LIMIT)
            return usage_error(program, "%s is given too often", option->name);
        list->values[list->count++] = text;
        return -1;
    }
    case AL_OPTION_INT:
        if (!parse_real(text, &value) || value != floor(value) || fabs(value) > 2147483647.0 ||
            !in_range(option, value))
            return range_error(program, option, text);
        *(int *)option->value = (int)value;
        return -1;
    case AL_OPTION_REAL:
        if (!parse_real(text, &value) || !in_range(option, value)) return range_error(program, option, text);
        *(double *)option->value = value;
        return -1;
    case AL_OPTION_SIZE: {
        char width[16];
        const char *cross = strchr(text, 'x');
        if (!cross || cross - text >= (ptrdiff_t)sizeof width) return range_error(program, option, text);
        memcpy(width, text, (size_t)(cross - text));
        width[cross - text] = 0;
        if (!parse_real(width, &value) || !parse_real(cross + 1, &second) || value != floor(value) ||
            second != floor(second) || !in_range(option, value) || !in_range(option, second))
            return range_error(program, option, text);
        ((int *)option->value)[0] = (int)value;
        ((int *)option->value)[1] = (int)second;
        return -1;
    }
    }
    return AL_USAGE;
}

static const al_option *find_option(const al_program *program, const char *name, size_t length)
{
    for (size_t i = 0; i < program->option_count; i++)
        if (strlen(program->options[i].name) == length && !memcmp(program->options[i].name, name, length))
            return &program->options[i];
    return NULL;
}

int al_program_parse(al_program *program, int argc, char **argv, const char **positionals, size_t minimum,
                     size_t limit, size_t *positional_count)
{
    *positional_count = 0;
    bool options_end = false;
    for (int i = 1; i < argc; i++) {
        const char *word = argv[i];
        if (options_end || word[0] != '-' || word[1] == 0) {
            if (*positional_count == limit)
                return usage_error(program, "'%s' is one argument too many", word);
            if (!*word) return usage_error(program, "an argument is empty");
            positionals[(*positional_count)++] = word;
            continue;
        }
        if (!strcmp(word, "--")) {
            options_end = true;
            continue;
        }
        if (!strcmp(word, "--help")) return print_help(program), al_program_end(program, AL_OK);
        if (!strcmp(word, "--version")) {
            printf("%s %s\n", program->name, AIRLIGHT_VERSION);
            return al_program_end(program, AL_OK);
        }
        if (!strcmp(word, "--quiet")) {
            program->quiet = true;
            continue;
        }
        if (!strcmp(word, "--verbose")) {
            program->verbose = true;
            continue;
        }
        const char *equals = strchr(word, '=');
        size_t length = equals ? (size_t)(equals - word) : strlen(word);
        const al_option *option = find_option(program, word, length);
        if (!option) return usage_error(program, "unknown option '%s'", word);
        const char *text = equals ? equals + 1 : NULL;
        if (option->kind == AL_OPTION_FLAG) {
            if (text) return usage_error(program, "%s takes no value", option->name);
        } else if (!text) {
            if (i + 1 == argc) return usage_error(program, "%s needs %s", option->name, option->argument);
            text = argv[++i];
        }
        int code = set_value(program, option, text);
        if (code >= 0) return code;
    }
    if (*positional_count < minimum) {
        fprintf(stderr, "%s: an argument is missing; usage: %s %s\n", program->name, program->name,
                program->usage);
        return AL_USAGE;
    }
    return -1;
}

al_status al_program_check_ending(const char *option, const char *path, const char *ending, al_error *error)
{
    size_t length = strlen(path), tail = strlen(ending);
    if (length > tail && !strcmp(path + length - tail, ending)) return AL_OK;
    return al_fail(error, AL_USAGE, "%s takes a name that ends in %s, not '%s'", option, ending, path);
}

int al_program_fail(const al_program *program, const al_error *error)
{
    print_line(program, error->message, "");
    return (int)error->status;
}

int al_program_end(const al_program *program, int code)
{
    al_error error;
    if (fflush(stdout) == 0 && !ferror(stdout)) return code;
    al_fail(&error, AL_IO, "standard output: cannot write: %s", strerror(errno));
    return code > AL_CHECK_FAILED ? code : al_program_fail(program, &error);
}

void al_program_say(const al_program *program, const char *format, ...)
{
    if (program->quiet) return;
    char message[AL_ERROR_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    print_line(program, message, "");
}

/* Blocked in every thread, a signal waits until somebody looks. A handler would not do: compilers inside
 * OpenCL drivers put their own in its place, which remove the files they work on. */
static sigset_t cancelling_signals(void)
{
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    return signals;
}

void al_program_catch_signals(void)
{
    sigset_t signals = cancelling_signals();
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
}

bool al_program_cancelled(void)
{
    sigset_t waiting;
    return sigpending(&waiting) == 0 &&
           (sigismember(&waiting, SIGINT) == 1 || sigismember(&waiting, SIGTERM) == 1);
}

double al_program_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void al_progress_begin(al_progress *progress, const al_program *program, const char *step)
{
    *progress = (al_progress){program, step, al_program_seconds(), -1e9};
}

static void print_bar(const al_progress *progress, double share, double elapsed_s)
{
    enum { WIDTH = 30 };
    char bar[WIDTH + 1];
    int filled = (int)(share * WIDTH);
    for (int i = 0; i < WIDTH; i++) bar[i] = i < filled ? '#' : '.';
    bar[WIDTH] = 0;
    fprintf(stderr, "\r%-16s [%s] %5.1f %%  %.1f s", progress->step, bar, 100 * share, elapsed_s);
    if (share > 0.01 && share < 1) fprintf(stderr, ", %.0f s left", elapsed_s * (1 - share) / share);
    fputs("   ", stderr);
}

bool al_progress_update(al_progress *progress, double done, double total)
{
    enum { LINE_EVERY_S = 5 };
    double now = al_program_seconds(), share = total > 0 ? fmin(done / total, 1) : 1;
    bool terminal = isatty(STDERR_FILENO);
    double pause = terminal ? 0.1 : LINE_EVERY_S;
    /* The first line of a step without a terminal waits too, so that quick steps stay silent. */
    if (!terminal && progress->printed_s < 0) progress->printed_s = progress->started_s;
    if (!progress->program->quiet && now - progress->printed_s >= pause) {
        double elapsed_s = now - progress->started_s;
        if (terminal)
            print_bar(progress, share, elapsed_s);
        else
            fprintf(stderr, "%s: %s: %.0f %%, %.0f s, %.0f s left\n", progress->program->name, progress->step,
                    100 * share, elapsed_s, share > 0 ? elapsed_s * (1 - share) / share : 0);
        progress->printed_s = now;
    }
    return al_program_cancelled();
}

void al_progress_end(al_progress *progress)
{
    if (progress->program->quiet || !isatty(STDERR_FILENO)) return;
    print_bar(progress, 1, al_program_seconds() - progress->started_s);
    fputc('\n', stderr);
}
