#include "shader.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "al_shader_text.h"

enum { FILE_LIMIT = 24, NAME_SIZE = 64 };

typedef struct entry {
    char *key; /* stages and defines */
    GLuint program;
    struct entry *next;
} entry;

struct al_shaders {
    char *folder;
    entry *entries;
};

/* One stage while its text grows; files[i] is source string number i of #line. */
typedef struct expansion {
    const al_shaders *shaders;
    const char *defines;
    char files[FILE_LIMIT][NAME_SIZE];
    int file_count;
    char *text;
    size_t size, capacity;
    al_error *error;
} expansion;

al_status al_shaders_create(const char *folder, al_shaders **shaders, al_error *error)
{
    al_shaders *made = calloc(1, sizeof *made);
    *shaders = NULL;
    if (made && folder) made->folder = strdup(folder);
    if (!made || (folder && !made->folder)) {
        free(made);
        return al_fail(error, AL_IO, "no memory for shaders");
    }
    *shaders = made;
    return AL_OK;
}

void al_shaders_free(al_shaders *shaders)
{
    if (!shaders) return;
    while (shaders->entries) {
        entry *next = shaders->entries->next;
        glDeleteProgram(shaders->entries->program);
        free(shaders->entries->key);
        free(shaders->entries);
        shaders->entries = next;
    }
    free(shaders->folder);
    free(shaders);
}

static al_status read_file(const char *path, char **text, al_error *error)
{
    al_status status = AL_OK;
    long size;
    FILE *file = fopen(path, "rb");
    *text = NULL;
    if (!file) return al_fail_errno(error, path, "open");
    if (fseek(file, 0, SEEK_END) || (size = ftell(file)) < 0 || fseek(file, 0, SEEK_SET)) {
        status = al_fail_errno(error, path, "read");
        goto cleanup;
    }
    *text = calloc((size_t)size + 1, 1);
    if (!*text) {
        status = al_fail(error, AL_IO, "%s: no memory for %ld bytes", path, size);
    } else if (fread(*text, 1, (size_t)size, file) != (size_t)size) {
        status = al_fail(error, AL_IO, "%s: cannot read all of it", path);
        free(*text);
        *text = NULL;
    }
cleanup:
    fclose(file);
    return status;
}

/* The text of `name`, to be freed. */
static al_status load(const al_shaders *shaders, const char *name, char **text, al_error *error)
{
    *text = NULL;
    if (shaders->folder) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", shaders->folder, name);
        if (access(path, F_OK) == 0) return read_file(path, text, error);
    }
    for (unsigned i = 0; i < al_shader_text_count; i++) {
        if (strcmp(al_shader_text_names[i], name) != 0) continue;
        *text = strdup(al_shader_text_texts[i]);
        return *text ? AL_OK : al_fail(error, AL_IO, "%s: no memory", name);
    }
    return al_fail(error, AL_BAD_INPUT, "%s: no such shader file in the folder or among the embedded ones",
                   name);
}

static al_status append(expansion *e, const char *text, size_t size)
{
    if (size > e->capacity - e->size) {
        size_t capacity = (e->capacity + size) * 2 + 1024;
        char *grown = realloc(e->text, capacity);
        if (!grown) return al_fail(e->error, AL_IO, "no memory for a shader of %zu bytes", capacity);
        e->text = grown;
        e->capacity = capacity;
    }
    memcpy(e->text + e->size, text, size);
    e->size += size;
    return AL_OK;
}

static al_status append_line_number(expansion *e, int line, int file)
{
    char text[64];
    int size = snprintf(text, sizeof text, "#line %d %d\n", line, file);
    return append(e, text, (size_t)size);
}

static al_status expand(expansion *e, const char *name);

/* `line` starts with #include ": appends the file it names, unless it is there already. */
static al_status expand_include(expansion *e, const char *line, int number, int file)
{
    char name[NAME_SIZE];
    const char *begin = strchr(line, '"') + 1, *end = strchr(begin, '"');
    if (!end || (size_t)(end - begin) >= sizeof name)
        return al_fail(e->error, AL_BAD_INPUT,
                       "%s:%d: an include must name a file of fewer than %d characters", e->files[file],
                       number, NAME_SIZE);
    memcpy(name, begin, (size_t)(end - begin));
    name[end - begin] = 0;
    char *slash = strrchr(name, '/'); /* shared headers are embedded under their bare name */
    if (slash) memmove(name, slash + 1, strlen(slash + 1) + 1);
    for (int i = 0; i < e->file_count; i++)
        if (strcmp(e->files[i], name) == 0) return append(e, "\n", 1);
    al_status status = expand(e, name);
    return status ? status : append_line_number(e, number + 1, file);
}

static al_status expand_line(expansion *e, const char *line, size_t size, int number, int file)
{
    if (strncmp(line, "#include \"", 10) == 0) return expand_include(e, line, number, file);
    if (strncmp(line, "#extension GL_GOOGLE_include_directive", 38) == 0) return append(e, "\n", 1);
    al_status status = append(e, line, size);
    if (!status && strncmp(line, "#version", 8) == 0) {
        status = append(e, e->defines, strlen(e->defines));
        if (!status) status = append_line_number(e, number + 1, file);
    }
    return status;
}

static al_status expand(expansion *e, const char *name)
{
    char *text = NULL;
    int file = e->file_count, number = 1;
    if (file == FILE_LIMIT)
        return al_fail(e->error, AL_BAD_INPUT, "%s: more than %d included files", name, FILE_LIMIT);
    snprintf(e->files[e->file_count++], NAME_SIZE, "%s", name);
    al_status status = load(e->shaders, name, &text, e->error);
    if (!status && file) status = append_line_number(e, 1, file);
    for (const char *line = text; !status && line && *line; number++) {
        const char *end = strchr(line, '\n');
        size_t size = end ? (size_t)(end - line) + 1 : strlen(line);
        status = expand_line(e, line, size, number, file);
        line += size;
    }
    free(text);
    return status;
}

/* Writes log and text beside each other and answers the file's name in `path`. */
static void write_log(const char *log, const expansion *e, char *path, size_t path_size)
{
    const char *folder = getenv("TMPDIR");
    snprintf(path, path_size, "%s/airlight-shader-XXXXXX", folder && *folder ? folder : "/tmp");
    int descriptor = mkstemp(path);
    FILE *file = descriptor < 0 ? NULL : fdopen(descriptor, "wb");
    if (!file) {
        snprintf(path, path_size, "(no log: %s)", strerror(errno));
        return;
    }
    fprintf(file, "%s\n", log);
    if (e) {
        for (int i = 0; i < e->file_count; i++) fprintf(file, "// source string %d: %s\n", i, e->files[i]);
        fwrite(e->text, 1, e->size, file);
    }
    fclose(file);
}

static al_status fail_with_log(const char *name, const char *log, const expansion *e, al_error *error)
{
    char path[512], first[256];
    write_log(log, e, path, sizeof path);
    snprintf(first, sizeof first, "%.*s", (int)strcspn(log, "\n"), log);
    return al_fail(error, AL_BAD_INPUT, "%s: the shader does not build: %s; whole log: %s", name, first,
                   path);
}

static GLenum stage_of(const char *name)
{
    static const struct {
        const char *ending;
        GLenum stage;
    } stages[] = {{".vert", GL_VERTEX_SHADER},          {".tesc", GL_TESS_CONTROL_SHADER},
                  {".tese", GL_TESS_EVALUATION_SHADER}, {".geom", GL_GEOMETRY_SHADER},
                  {".comp", GL_COMPUTE_SHADER}};
    const char *ending = strrchr(name, '.');
    for (size_t i = 0; ending && i < sizeof stages / sizeof stages[0]; i++)
        if (!strcmp(ending, stages[i].ending)) return stages[i].stage;
    return GL_FRAGMENT_SHADER;
}

static al_status compile(const al_shaders *shaders, const char *name, const char *defines, GLuint program,
                         al_error *error)
{
    expansion e = {.shaders = shaders, .defines = defines, .error = error};
    GLint good = 0, size;
    GLuint shader = 0;
    al_status status = expand(&e, name);
    if (status) goto cleanup;
    shader = glCreateShader(stage_of(name));
    const char *text = e.text;
    size = (GLint)e.size;
    glShaderSource(shader, 1, &text, &size);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (!good) {
        char log[8192] = "";
        glGetShaderInfoLog(shader, sizeof log, NULL, log);
        status = fail_with_log(name, log, &e, error);
        goto cleanup;
    }
    glAttachShader(program, shader);
cleanup:
    if (shader) glDeleteShader(shader); /* stays with the program while attached */
    free(e.text);
    return status;
}

static al_status build(const al_shaders *shaders, const char *stages, const char *defines, GLuint *result,
                       al_error *error)
{
    char names[4 * NAME_SIZE], *rest = NULL;
    GLuint program = glCreateProgram();
    GLint good = 0;
    al_status status = AL_OK;
    snprintf(names, sizeof names, "%s", stages);
    for (char *name = strtok_r(names, " ", &rest); name && !status; name = strtok_r(NULL, " ", &rest))
        status = compile(shaders, name, defines, program, error);
    if (!status) {
        glLinkProgram(program);
        glGetProgramiv(program, GL_LINK_STATUS, &good);
        if (!good) {
            char log[8192] = "";
            glGetProgramInfoLog(program, sizeof log, NULL, log);
            status = fail_with_log(stages, log, NULL, error);
        }
    }
    if (status) glDeleteProgram(program);
    *result = status ? 0 : program;
    return status;
}

al_status al_shaders_get(al_shaders *shaders, const char *stages, const char *defines, GLuint *program,
                         al_error *error)
{
    char key[1024];
    snprintf(key, sizeof key, "%s|%s", stages, defines);
    *program = 0;
    for (entry *e = shaders->entries; e; e = e->next) {
        if (strcmp(e->key, key) != 0) continue;
        *program = e->program;
        return AL_OK;
    }
    entry *made = calloc(1, sizeof *made);
    if (made) made->key = strdup(key);
    al_status status = made && made->key ? build(shaders, stages, defines, &made->program, error)
                                         : al_fail(error, AL_IO, "no memory for shaders");
    if (status) {
        if (made) free(made->key);
        free(made);
        return status;
    }
    made->next = shaders->entries;
    shaders->entries = made;
    *program = made->program;
    return AL_OK;
}
