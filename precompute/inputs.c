#include "inputs.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <xxhash.h>

enum { PADDING = 16, PIECE = 1 << 20 };

static al_status note(al_import *import, const char *path, uint64_t hash, al_error *error)
{
    for (uint32_t i = 0; i < import->input_count; i++)
        if (strcmp(import->inputs[i].path, path) == 0) return AL_OK;
    al_input *grown = realloc(import->inputs, (import->input_count + (size_t)1) * sizeof *grown);
    if (!grown) return al_fail(error, AL_IO, "%s: out of memory", path);
    import->inputs = grown;
    char *copy = strdup(path);
    if (!copy) return al_fail(error, AL_IO, "%s: out of memory", path);
    grown[import->input_count++] = (al_input){copy, hash};
    return AL_OK;
}

/* A folder opens like a file on Linux and only fails when it is read: say so at once. */
static FILE *open_file(const char *path, struct stat *facts, al_error *error, al_status *status)
{
    FILE *file = fopen(path, "rb");
    if (!file || fstat(fileno(file), facts)) {
        *status = al_fail_errno(error, path, "open");
    } else if (!S_ISREG(facts->st_mode)) {
        *status = al_fail(error, AL_BAD_INPUT, "%s: is not a file", path);
    } else {
        return file;
    }
    if (file) fclose(file);
    return NULL;
}

al_status al_inputs_read(al_import *import, const char *path, uint8_t **bytes, size_t *size, al_error *error)
{
    struct stat facts;
    al_status status = AL_OK;
    uint8_t *data = NULL;
    *bytes = NULL;
    *size = 0;
    FILE *file = open_file(path, &facts, error, &status);
    if (!file) return status;
    size_t wanted = (size_t)facts.st_size;
    data = calloc(wanted + PADDING, 1);
    if (!data) {
        status = al_fail(error, AL_IO, "%s: out of memory for a file of %zu bytes", path, wanted);
        goto cleanup;
    }
    if (fread(data, 1, wanted, file) != wanted) {
        status = al_fail(error, AL_IO, "%s: cannot read all of its %zu bytes", path, wanted);
        goto cleanup;
    }
    status = note(import, path, XXH64(data, wanted, 0), error);
    if (status) goto cleanup;
    *bytes = data;
    *size = wanted;
    data = NULL;
cleanup:
    free(data);
    fclose(file);
    return status;
}

al_status al_inputs_hash(al_import *import, const char *path, al_error *error)
{
    struct stat facts;
    al_status status = AL_OK;
    FILE *file = open_file(path, &facts, error, &status);
    if (!file) return status;
    XXH64_state_t *state = XXH64_createState();
    uint8_t *piece = malloc(PIECE);
    if (!state || !piece) {
        status = al_fail(error, AL_IO, "%s: out of memory", path);
        goto cleanup;
    }
    XXH64_reset(state, 0);
    for (size_t got; (got = fread(piece, 1, PIECE, file)) > 0;) XXH64_update(state, piece, got);
    status =
        ferror(file) ? al_fail_errno(error, path, "read") : note(import, path, XXH64_digest(state), error);
cleanup:
    free(piece);
    XXH64_freeState(state);
    fclose(file);
    return status;
}
