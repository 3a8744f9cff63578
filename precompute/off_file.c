#include "off_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const char *name, *at;
    size_t line;
    uint32_t vertex_count, face_count;
    float *positions; /* [vertex_count][3] */
} reader;

/* Goes to the first character of the next line that says something; false at the end. */
static bool next_line(reader *from)
{
    const char *at = from->at;
    if (from->line) at += strcspn(at, "\n");
    for (;;) {
        if (*at == '\n' || !from->line) {
            from->line++;
            at += *at == '\n' && from->line > 1;
        }
        at += strspn(at, " \t\r");
        if (*at == '#') at += strcspn(at, "\n");
        if (*at != '\n') break;
    }
    from->at = at;
    return *at != 0;
}

static al_status fail_line(const reader *from, const char *right, al_error *error)
{
    return al_fail(error, AL_BAD_INPUT, "%s: line %zu: %s", from->name, from->line, right);
}

static bool read_count(const char **at, uint32_t limit, uint32_t *out)
{
    char *end;
    unsigned long long value = strtoull(*at, &end, 10);
    bool good = end != *at && (*at)[strspn(*at, " \t")] != '-' && value <= limit;
    *at = end;
    *out = good ? (uint32_t)value : 0;
    return good;
}

/* [ST][C][N]OFF: any of these begins with positions on its vertex lines. 4OFF and nOFF do not. */
static al_status read_head(reader *from, al_error *error)
{
    static const char *const words[] = {"OFF",   "COFF",   "NOFF",   "CNOFF",
                                        "STOFF", "STCOFF", "STNOFF", "STCNOFF"};
    if (!next_line(from)) return fail_line(from, "the file is empty; OFF is right", error);
    size_t size = strcspn(from->at, " \t\r\n");
    bool word = false;
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        word = word || (strlen(words[i]) == size && memcmp(words[i], from->at, size) == 0);
    if (!word && !strchr("0123456789", *from->at))
        return fail_line(from, "is no text OFF; \"OFF\" and counts are right", error);
    if (word) from->at += size;
    from->at += strspn(from->at, " \t\r");
    if (strchr("\n#", *from->at) && !next_line(from)) return fail_line(from, "counts are missing", error);
    const char *at = from->at;
    if (!read_count(&at, UINT32_MAX / 16, &from->vertex_count) ||
        !read_count(&at, UINT32_MAX / 16, &from->face_count))
        return fail_line(from, "the numbers of vertices and faces are right here", error);
    return AL_OK;
}

static al_status read_vertices(reader *from, size_t size, al_error *error)
{
    if (from->vertex_count > size)
        return fail_line(from, "names more vertices than the file can hold", error);
    from->positions = malloc((from->vertex_count + (size_t)1) * sizeof(float[3]));
    if (!from->positions) return al_fail(error, AL_IO, "%s: out of memory for its vertices", from->name);
    for (uint32_t i = 0; i < from->vertex_count; i++) {
        if (!next_line(from)) return fail_line(from, "the file ends within the vertices", error);
        const char *at = from->at;
        for (int k = 0; k < 3; k++) {
            char *end;
            double value = strtod(at, &end);
            if (end == at || strchr(at, '\n') < end)
                return fail_line(from, "three coordinates are right here", error);
            from->positions[i * (size_t)3 + k] = (float)value;
            if (!isfinite(from->positions[i * (size_t)3 + k]))
                return al_fail(error, AL_BAD_INPUT,
                               "%s: line %zu: vertex %u has the coordinate %g; finite numbers "
                               "are right",
                               from->name, from->line, i, value);
            at = end;
        }
    }
    return AL_OK;
}

static void put_corner(const reader *from, uint32_t vertex, al_corners *out)
{
    size_t to = out->count++;
    memcpy(out->positions + to * 3, from->positions + vertex * (size_t)3, sizeof(float[3]));
    memset(out->normals + to * 3, 0, sizeof(float[3]));
    memset(out->uv0 + to * 2, 0, sizeof(float[2]));
    memset(out->uv1 + to * 2, 0, sizeof(float[2]));
}

static al_status read_face(reader *from, al_corners *out, al_error *error)
{
    const char *at = from->at;
    uint32_t count, first, before, here;
    if (!read_count(&at, UINT32_MAX / 16, &count))
        return fail_line(from, "a number of corners is right here", error);
    for (uint32_t i = 0; i < count; i++) {
        if (!read_count(&at, UINT32_MAX / 16, &here) || here >= from->vertex_count)
            return fail_line(from, "corners that are numbers of vertices, from 0, are right here", error);
        if (i == 0) first = here;
        if (i >= 2) {
            al_status status = al_corners_reserve(out, 3, error);
            if (status) return status;
            put_corner(from, first, out);
            put_corner(from, before, out);
            put_corner(from, here, out);
        }
        before = here;
    }
    return AL_OK;
}

al_status al_off_corners(const char *name, const char *text, al_corners *corners, al_error *error)
{
    reader from = {.name = name, .at = text};
    al_status status = read_head(&from, error);
    if (!status) status = read_vertices(&from, strlen(text), error);
    for (uint32_t i = 0; i < from.face_count && !status; i++)
        status = next_line(&from) ? read_face(&from, corners, error)
                                  : fail_line(&from, "the file ends within the faces", error);
    free(from.positions);
    return status;
}
