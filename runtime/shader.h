/* Shader programs from the embedded texts or a folder, with #include "name" and defines.
 *
 * A line `#include "name"` is replaced by the text of that file, once per program; #include <...> is left to
 * the preprocessor, which never reaches it in GLSL. Programs are built on first use and kept. */
#ifndef AIRLIGHT_RUNTIME_SHADER_H
#define AIRLIGHT_RUNTIME_SHADER_H

#include <epoxy/gl.h>

#include "airlight/status.h"

typedef struct al_shaders al_shaders;

/* folder: NULL for the embedded texts; a file missing in the folder is taken from the embedded ones. */
al_status al_shaders_create(const char *folder, al_shaders **shaders, al_error *error);
void al_shaders_free(al_shaders *shaders);

/* `stages`: file names separated by a blank ("splat.vert splat.frag" or "light.comp"); `defines`: lines put
 * behind #version, "" for none. A compile or link error names the file, and a file with the whole log. */
al_status al_shaders_get(al_shaders *shaders, const char *stages, const char *defines, GLuint *program,
                         al_error *error);

#endif
