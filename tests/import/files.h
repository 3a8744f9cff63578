/* Small files that the import tests write for themselves, in the test's working folder. */
#ifndef AIRLIGHT_TEST_FILES_H
#define AIRLIGHT_TEST_FILES_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/status.h"

static inline void write_bytes(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file)) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
}

static inline void write_text(const char *path, const char *text)
{
    write_bytes(path, text, strlen(text));
}

/* The status and the exact message of a refusal. */
static inline void check_refusal(const char *what, al_status status, const al_error *error, al_status expected,
                                 const char *message)
{
    test_checks++;
    if (status != expected || error->status != expected || strcmp(error->message, message) != 0) {
        test_failures++;
        fprintf(stderr, "%s\n  answers %d: %s\n  not     %d: %s\n", what, (int)status, status ? error->message : "",
                (int)expected, message);
    }
}

/* The status, and a message that contains every one of the parts ("a|b"). */
static inline void check_mentions(const char *what, al_status status, const al_error *error, al_status expected,
                                  const char *parts)
{
    char part[256];
    bool good = status == expected && error->status == expected && !strchr(error->message, '\n');
    for (const char *at = parts; good && *at;) {
        size_t size = strcspn(at, "|");
        snprintf(part, sizeof part, "%.*s", (int)size, at);
        good = strstr(error->message, part) != NULL;
        at += size + (at[size] == '|');
    }
    test_checks++;
    if (!good) {
        test_failures++;
        fprintf(stderr, "%s\n  answers %d: %s\n  not     %d with: %s\n", what, (int)status,
                status ? error->message : "", (int)expected, parts);
    }
}

/* Folder of the optional reference data. */
static inline const char *shared_folder(void)
{
    const char *folder = getenv("AIRLIGHT_SHARED");
    return folder ? folder : AIRLIGHT_SHARED_DEFAULT;
}

#endif
