/* airlight-play: shows a baked folder in a window, or renders it without a display. */
#include "headless.h"
#include "window.h"

int main(int argc, char **argv)
{
    al_program program = {
        .name = "airlight-play",
        .usage = "DIR [options]",
        .summary = "Shows what airlight-bake wrote into DIR in a window (H lists the keys), or renders it\n"
                   "without a display with --headless. EXR pictures hold linear radiance in W/(m2 sr).\n"
                   "PNG pictures and the window show radiance times 2^EV, straight up to 0.6 and then along\n"
                   "an exponential shoulder that tends to 1, in sRGB.",
    };
    al_play_options options;
    int code = al_play_options_parse(&program, argc, argv, &options);
    if (code >= 0) return code;
    al_program_catch_signals();
    return options.headless ? al_headless_run(&program, &options) : al_window_run(&program, &options);
}
