/* The host example draws a baked folder in a window of its own, under a virtual X server. */
#include <stdio.h>
#include <stdlib.h>

#include "../test.h"
#include "sphere.h"
#include "stage.h"

int main(int argc, char **argv)
{
    char command[1024];
    sphere_scene s;
    if (argc < 2) return 2;
    if (system("command -v xvfb-run >/dev/null 2>&1")) return test_skip("no xvfb-run");
    const char *folder = stage_folder();
    sphere_scene_begin(&s);
    sphere_scene_add(&s, "sphere.air", 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, 0, -1}, 1);
    CHECK(sphere_write_asset(folder, "sphere.air", &(sphere_options){.samples = 500, .grid = 32}));
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
    /* With its window the driver is unloaded, before leaks are looked for: its own cannot be told by its
     * name. */
    snprintf(command, sizeof command,
             "LSAN_OPTIONS=detect_leaks=0 xvfb-run -a -s '-screen 0 1280x800x24' '%s' '%s' 3", argv[1],
             folder);
    int code = system(command);
    if (code == 5 << 8) return test_skip("no window with OpenGL 4.5");
    CHECK(code == 0);
    snprintf(command, sizeof command, "xvfb-run -a '%s' /nowhere 1 2>&1 | grep -q '/nowhere: no scene.air'",
             argv[1]);
    CHECK(system(command) == 0);
    return test_end();
}
