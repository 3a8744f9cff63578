/* A gather from a few words of JSON, and means over repetitions with independent seeds. */
#ifndef AIRLIGHT_GATHER_FOR_TEST_H
#define AIRLIGHT_GATHER_FOR_TEST_H

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "../test.h"
#include "gather.h"

typedef struct test_gather {
    al_import *import;
    al_gather *gather;
    al_gather_scratch *scratch;
} test_gather;

static inline void close_gather(test_gather *test)
{
    al_gather_scratch_free(test->scratch);
    al_gather_close(test->gather);
    al_import_free(test->import);
    *test = (test_gather){0};
}

/* `json` is the scene file with ' for ". Ends the test program when it is no scene. */
static inline al_import *import_text(const char *json)
{
    char path[64];
    snprintf(path, sizeof path, "gather_of_test_%ld.json", (long)getpid());
    al_import *import;
    al_error error = {0};
    FILE *file = fopen(path, "w");
    for (const char *c = json; file && *c; c++) fputc(*c == '\'' ? '"' : *c, file);
    if (!file || fclose(file)) {
        perror(path);
        exit(1);
    }
    if (al_import_scene(path, AL_QUALITY_FINAL, &import, &error)) {
        fprintf(stderr, "%s\n", error.message);
        exit(1);
    }
    remove(path);
    return import;
}

static inline test_gather open_gather(const char *json, const al_impulse_tables *tables,
                                      const al_gather_options *options)
{
    test_gather test = {.import = import_text(json)};
    al_error error = {0};
    if (al_gather_open(test.import, tables, options, &test.gather, &error)) {
        fprintf(stderr, "%s\n", error.message);
        exit(1);
    }
    test.scratch = al_gather_scratch_new(test.gather);
    return test;
}

static inline al_gathered gather_at(const test_gather *test, const double position[3], const double *normal,
                                    uint64_t seed)
{
    al_gathered gathered;
    if (!al_gather_point(test->gather, test->scratch, position, normal, 0.01, seed, &gathered)) exit(1);
    return gathered;
}

#endif
