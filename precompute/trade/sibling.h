/* Runs another airlight program, found beside this one. */
#ifndef AIRLIGHT_SIBLING_H
#define AIRLIGHT_SIBLING_H

#include "trade.h"

enum { AL_WORD_LIMIT = 80, AL_WORDS_SIZE = 16384 };
typedef struct al_command {
    const char *program; /* "airlight-bake" */
    char text[AL_WORDS_SIZE];
    size_t used;
    char *words[AL_WORD_LIMIT + 1];
    int count;
} al_command;

void al_command_begin(al_command *command, const char *program);
void al_command_add(al_command *command, const char *format, ...) AL_PRINTF(2, 3);

/* Waits for its end, with progress; Ctrl-C is handed on. *output is its standard output, free() it; may be NULL. When it
 * fails, its exit code is the status and its own line the message. */
al_status al_command_run(al_trade *trade, al_command *command, char **output, al_error *error);

#endif
