/* airlight-inspect: what an asset holds, whether it is valid, what it says at a point, how it looks. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/program.h"
#include "inspect.h"

static const inspected_kind *const kinds[] = {&inspected_translucent, &inspected_scene,
                                             &inspected_impulse_tables, &inspected_lightmap, &inspected_probes, &inspected_medium};

typedef struct request {
    bool check, json;
    const char *query, *image;
} request;

static const inspected_kind *find_kind(al_kind kind)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (kinds[i]->kind == kind) return kinds[i];
    return NULL;
}

/* --- checking --- */

static void keep_finding(void *user, int rule, const char *message)
{
    json_array_append_new(user, json_pack("{s:i,s:o}", "rule", rule, "message", json_text(message)));
}

static void print_findings(const json_t *findings)
{
    for (size_t i = 0; i < json_array_size(findings); i++) {
        const json_t *finding = json_array_get(findings, i);
        printf("rule %d: %s\n", (int)json_integer_value(json_object_get(finding, "rule")),
               json_string_value(json_object_get(finding, "message")));
    }
}

/* --- describing --- */

static json_t *describe_chunks(const al_file *file)
{
    json_t *list = json_array();
    for (size_t i = 0; i < al_file_chunk_count(file); i++) {
        const al_chunk *c = al_file_chunk(file, i);
        char checksum[17];
        snprintf(checksum, sizeof checksum, "%016" PRIx64, c->checksum);
        json_array_append_new(list,
                              json_pack("{s:s,s:i,s:b,s:I,s:I,s:I,s:s}", "type", c->type, "version",
                                        (int)c->version, "optional", (int)(c->flags & AL_CHUNK_OPTIONAL),
                                        "offset", (json_int_t)c->offset, "size", (json_int_t)c->size,
                                        "raw_size", (json_int_t)c->raw_size, "checksum", checksum));
    }
    return list;
}

static json_t *describe(const al_file *file, json_t *summary)
{
    char version[16];
    snprintf(version, sizeof version, "%u.%u", al_file_major(file), al_file_minor(file));
    return json_pack("{s:s,s:s,s:s,s:I,s:o,s:O}", "kind", al_kind_name(al_file_kind(file)), "format_version",
                     version, "writer", al_file_writer(file), "size", (json_int_t)al_file_size(file),
                     "chunks", describe_chunks(file), "summary", summary);
}

static void print_measured(const json_t *measured)
{
    for (size_t i = 0; i < json_array_size(measured); i++) {
        const json_t *m = json_array_get(measured, i);
        const char *unit = json_string_value(json_object_get(m, "unit"));
        const json_t *relative = json_object_get(m, "relative_rmse");
        printf("\nmeasured: %s\n  %lld numbers; %s\n  ", json_string_value(json_object_get(m, "compared")),
               (long long)json_integer_value(json_object_get(m, "count")),
               json_string_value(json_object_get(m, "settings")));
        if (json_is_real(relative)) printf("relative RMSE %.4g, ", json_real_value(relative));
        printf("RMSE %.4g%s%s, largest deviation %.4g", json_number_value(json_object_get(m, "rmse")),
               *unit ? " " : "", unit, json_number_value(json_object_get(m, "largest")));
        double noise = json_number_value(json_object_get(m, "standard_error"));
        if (noise > 0) printf(", standard error of the truth %.4g", noise);
        printf("\n");
    }
}

static void print_text(const al_file *file, const json_t *summary, const json_t *measured)
{
    printf("%s: %s, format %u.%u, written by %s, %" PRIu64 " bytes\n\n", al_file_name(file),
           al_kind_name(al_file_kind(file)), al_file_major(file), al_file_minor(file), al_file_writer(file),
           al_file_size(file));
    printf("chunk  version  flags             offset               size  checksum\n");
    for (size_t i = 0; i < al_file_chunk_count(file); i++) {
        const al_chunk *c = al_file_chunk(file, i);
        printf("%s   %7u  %-8s %15" PRIu64 " %18" PRIu64 "  %016" PRIx64 "\n", c->type, c->version,
               c->flags & AL_CHUNK_OPTIONAL ? "optional" : "-", c->offset, c->size, c->checksum);
    }
    printf("\n");
    for (void *i = json_object_iter((json_t *)summary); i; i = json_object_iter_next((json_t *)summary, i)) {
        char *text = json_dumps(json_object_iter_value(i), JSON_ENCODE_ANY | JSON_REAL_PRECISION(7));
        printf("%-20s %s\n", json_object_iter_key(i), text ? text : "");
        free(text);
    }
    print_measured(measured);
}

static void print_json(const json_t *value)
{
    json_dumpf(value, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    printf("\n");
}

/* --- one file --- */

static al_status answer(const al_file *file, const inspected_kind *kind, const char *text, al_error *error)
{
    json_error_t where;
    json_t *query = json_loads(text, JSON_REJECT_DUPLICATES, &where), *reply = NULL;
    al_status status;
    if (!json_is_object(query))
        status = al_fail(error, AL_USAGE, "--eval: '%s' is no JSON object: %s", text,
                         query ? "it should be {...}" : where.text);
    else if (!kind->evaluate)
        status = al_fail(error, AL_USAGE, "--eval: an asset of kind %s answers no questions",
                         al_kind_name(kind->kind));
    else
        status = kind->evaluate(file, query, &reply, error);
    if (status == AL_OK) {
        json_dumpf(reply, stdout, JSON_REAL_PRECISION(9));
        printf("\n");
    }
    json_decref(query);
    json_decref(reply);
    return status;
}

static al_status show(const al_file *file, const inspected_kind *kind, const request *asked,
                      const json_t *findings, al_error *error)
{
    json_t *summary = NULL;
    al_status status = kind->summary(file, &summary, error);
    if (status != AL_OK) return status;
    json_t *measured = json_measured(file);
    if (asked->json) {
        if (json_array_size(measured)) json_object_set(summary, "measured", measured);
        json_t *all = describe(file, summary);
        json_object_set_new(all, "valid", json_boolean(!json_array_size(findings)));
        print_json(all);
        json_decref(all);
    } else {
        print_text(file, summary, measured);
    }
    json_decref(measured);
    json_decref(summary);
    return AL_OK;
}

/* The asset is valid: everything that was asked of it. */
static al_status inspect_valid(const char *path, const request *asked, const json_t *findings,
                               al_error *error)
{
    al_file *file;
    al_status status = al_file_open(path, NULL, &file, error);
    if (status != AL_OK) return status;
    const inspected_kind *kind = find_kind(al_file_kind(file));
    if (!kind)
        status = al_fail(error, AL_BAD_INPUT, "%s: assets of kind %s cannot be inspected", path,
                         al_kind_name(al_file_kind(file)));
    if (status == AL_OK && asked->image) status = kind->draw(file, asked->image, error);
    if (status == AL_OK && asked->query) status = answer(file, kind, asked->query, error);
    bool only_check = asked->check && !asked->json;
    if (status == AL_OK && !only_check && !asked->query && (asked->json || !asked->image))
        status = show(file, kind, asked, findings, error);
    if (status == AL_OK && only_check) printf("%s: valid\n", path);
    al_file_close(file);
    return status;
}

/* The asset is not valid, but what can still be read of header and table is worth showing. */
static void show_invalid(const char *path, const request *asked, json_t *findings)
{
    al_file *file = NULL;
    if (!asked->json) {
        if (asked->check) print_findings(findings);
        return;
    }
    json_t *summary = json_object();
    json_t *all = al_file_open(path, NULL, &file, NULL) == AL_OK
                      ? describe(file, summary)
                      : json_pack("{s:n,s:n,s:n,s:n,s:[],s:O}", "kind", "format_version", "writer", "size",
                                  "chunks", "summary", summary);
    json_object_set_new(all, "valid", json_false());
    json_object_set(all, "findings", findings);
    print_json(all);
    json_decref(all);
    json_decref(summary);
    al_file_close(file);
}

static int inspect(const al_program *program, const char *path, const request *asked)
{
    al_error error;
    json_t *findings = json_array();
    al_status status = al_file_check(path, keep_finding, findings, &error);
    size_t count = json_array_size(findings);
    if (status == AL_OK) {
        status = inspect_valid(path, asked, findings, &error);
    } else if (count) {
        show_invalid(path, asked, findings);
        if (asked->check)
            status = al_fail(&error, AL_CHECK_FAILED, "%s: not valid, %zu finding%s", path, count,
                             count > 1 ? "s" : "");
    }
    json_decref(findings);
    return status == AL_OK ? AL_OK : al_program_fail(program, &error);
}

int main(int argc, char **argv)
{
    request asked = {0};
    const al_option options[] = {
        {"--check", NULL, AL_OPTION_FLAG, &asked.check,
         "validate everything, list all that is found; exit code 1 when the file is not valid", 0, 0},
        {"--json", NULL, AL_OPTION_FLAG, &asked.json, "header, chunks and statistics as JSON", 0, 0},
        {"--eval", "JSON", AL_OPTION_STRING, &asked.query,
         "what the asset says at a point. translucent: {\"position\": [x, y, z], \"direction\": [x, y, z]};\n"
         "                             lightmap: {\"position\": [x, y, z], \"normal\": [x, y, z]};\n"
         "                             media: {\"position\": [x, y, z], \"time\": t};\n"
         "                             impulse-tables: {\"emitter\": \"point\", \"distance\": 2, \"sigma_s\": 0.5, \"events\": [1]}", 0, 0},
        {"--image", "OUT.png", AL_OPTION_STRING, &asked.image, "draw the asset", 0, 0},
    };
    al_program program = {"airlight-inspect",
                          "FILE.air [options]",
                          "Shows what an asset holds: header, chunks, statistics.",
                          options,
                          sizeof options / sizeof *options,
                          false,
                          false};
    const char *path;
    size_t count;
    int code = al_program_parse(&program, argc, argv, &path, 1, 1, &count);
    if (code >= 0) return code;
    al_error error;
    if (asked.image && al_program_check_ending("--image", asked.image, ".png", &error))
        return al_program_fail(&program, &error);
    return al_program_end(&program, inspect(&program, path, &asked));
}
