#define _GNU_SOURCE /* memfd_create */
#include "sibling.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "beside.h"

extern char **environ;

void al_command_begin(al_command *command, const char *program)
{
    *command = (al_command){.program = program};
    al_command_add(command, "%s", program);
}

void al_command_add(al_command *command, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    size_t room = sizeof command->text - command->used;
    int length = vsnprintf(command->text + command->used, room, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= room || command->count == AL_WORD_LIMIT) {
        command->used = sizeof command->text; /* too long: al_command_run says so */
        return;
    }
    command->words[command->count++] = command->text + command->used;
    command->used += (size_t)length + 1;
}

static al_status start(const char *path, al_command *command, const int streams[2], pid_t *child, al_error *error)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none; /* the child ends at Ctrl-C, which waits here */
    if (posix_spawn_file_actions_init(&actions)) return al_fail(error, AL_IO, "%s: out of memory", path);
    if (posix_spawnattr_init(&attributes)) {
        posix_spawn_file_actions_destroy(&actions);
        return al_fail(error, AL_IO, "%s: out of memory", path);
    }
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    int failed = posix_spawn_file_actions_adddup2(&actions, streams[0], STDOUT_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&actions, streams[1], STDERR_FILENO);
    if (!failed) failed = posix_spawn(child, path, &actions, &attributes, command->words, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (!failed) return AL_OK;
    return al_fail(error, AL_IO, "%s: cannot be started: %s; it belongs beside the program that runs", path, strerror(failed));
}

static al_status wait_for(al_trade *trade, const char *path, pid_t child, int *ended, al_error *error)
{
    const struct timespec pause = {0, 10000000};
    bool told = false;
    for (;;) {
        pid_t found = waitpid(child, ended, WNOHANG);
        if (found == child) return told ? al_fail(error, AL_CANCELLED, "stopped; the same command goes on from here") : AL_OK;
        if (found < 0 && errno != EINTR) return al_fail_errno(error, path, "wait for");
        double done = 0, total = trade->points.count;
        for (int i = 0; i < trade->points.count; i++) done += trade->points.points[i].picture[0] != 0;
        if (al_progress_update(&trade->progress, done, total > 0 ? total : 1) && !told) {
            kill(child, SIGINT);
            told = true;
        }
        nanosleep(&pause, NULL);
    }
}

/* What a file in memory holds, as text; NULL when memory runs out. */
static char *read_text(int file)
{
    off_t size = lseek(file, 0, SEEK_END);
    char *text = size >= 0 ? calloc(1, (size_t)size + 1) : NULL;
    if (text && size && pread(file, text, (size_t)size, 0) != size) text[0] = 0;
    return text;
}

/* The last line of what it said, which is why it ended. */
static al_status explain(const char *program, int ended, int messages, al_error *error)
{
    char *text = read_text(messages), *line = text;
    for (char *at = text; at && *at; at++)
        if (*at == '\n') {
            *at = 0;
            if (at[1]) line = at + 1;
        }
    al_status status = WIFEXITED(ended) && WEXITSTATUS(ended) <= AL_NO_DEVICE ? (al_status)WEXITSTATUS(ended) : AL_IO;
    if (WIFEXITED(ended) && WEXITSTATUS(ended) == AL_CANCELLED) status = AL_CANCELLED;
    if (line && *line)
        al_fail(error, status, "%s", line);
    else
        al_fail(error, status, "%s: ended without a word (%s %d)", program, WIFSIGNALED(ended) ? "signal" : "exit code",
                WIFSIGNALED(ended) ? WTERMSIG(ended) : WEXITSTATUS(ended));
    free(text);
    return status;
}

al_status al_command_run(al_trade *trade, al_command *command, char **output, al_error *error)
{
    char path[PATH_MAX];
    pid_t child = 0;
    int ended = 0, streams[2] = {memfd_create("output", MFD_CLOEXEC), memfd_create("messages", MFD_CLOEXEC)};
    if (output) *output = NULL;
    al_status status = AL_OK;
    if (streams[0] < 0 || streams[1] < 0)
        status = al_fail_errno(error, command->program, "make files in memory for");
    else if (command->used >= sizeof command->text)
        status = al_fail(error, AL_IO, "%s: the names of its files are too long", command->program);
    if (!status) status = al_find_beside(command->program, path, error);
    if (!status) status = start(path, command, streams, &child, error);
    if (!status) status = wait_for(trade, path, child, &ended, error);
    if (!status && !(WIFEXITED(ended) && WEXITSTATUS(ended) == 0)) status = explain(command->program, ended, streams[1], error);
    if (!status && output && !(*output = read_text(streams[0])))
        status = al_fail(error, AL_IO, "%s: out of memory for what it says", command->program);
    for (int i = 0; i < 2; i++)
        if (streams[i] >= 0) close(streams[i]);
    return status;
}
