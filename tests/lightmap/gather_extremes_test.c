/* Extremes: every answer is finite and not negative, or the scene is refused. */
#include <string.h>

#include "gather_for_test.h"

/* A box of one metre, lit from inside by a lamp and a double-sided emissive lid. */
static const char *const box =
    "{'materials':[{'name':'wall','base_color':%g,'double_sided':true},"
    "{'name':'lid','base_color':0,'emission_w_m2_sr':%g,'double_sided':true}],"
    "'meshes':[{'name':'box','shape':{'type':'box'},'material':'wall','transform':{'scale':%g}},"
    "{'name':'lid','shape':{'type':'plane','width_m':0.2,'depth_m':0.2},'material':'lid',"
    "'transform':{'matrix':[%g,0,0,0,0,%g,0,0,0,0,%g,0,0,%g,0,1]}}],"
    "'lights':[{'type':'point','position_m':[%g,%g,0],'intensity_w_sr':1}],"
    "'media':[{'name':'fog','sigma_s_per_m':%g,'sigma_a_per_m':%g,'g':%g}],'fogs':['fog']}";

typedef struct extreme {
    double albedo, emission, size_m, lamp_y, sigma_s, sigma_a, g;
} extreme;

static bool is_good(const al_gathered *g)
{
    for (int c = 0; c < 3; c++) {
        if (!(g->surface[c] >= 0 && isfinite(g->surface[c]))) return false;
        if (!(g->attenuated[c] >= 0 && g->attenuated[c] <= g->surface[c] * (1 + 1e-9) + 1e-300)) return false;
        if (!(g->scattered[c] >= -1e-12 * g->surface[c] && isfinite(g->scattered[c]))) return false;
        for (int k = 0; k < 9; k++)
            if (!isfinite(g->sh[AL_GATHER_SCATTERED][c][k])) return false;
    }
    return true;
}

static void check_extreme(const extreme *e, al_walls walls)
{
    char text[2048];
    double s = e->size_m;
    al_gather_options options = {.samples = 16,
                                 .bounces = 8,
                                 .fog = true,
                                 .walls = walls,
                                 .sh_order = 3,
                                 .threads = 1,
                                 .fog_points = 4,
                                 .fog_samples = 8};
    snprintf(text, sizeof text, box, e->albedo, e->emission, s, s, s, s, 0.4 * s, 0.0, e->lamp_y * s,
             e->sigma_s / s, e->sigma_a / s, e->g);
    test_gather test = {.import = import_text(text)};
    al_error error = {0};
    al_status status = al_gather_open(test.import, NULL, &options, &test.gather, &error);
    CHECK(status == AL_OK || (status == AL_BAD_INPUT &&
           (strstr(error.message, "too dense") || strstr(error.message, "does not settle"))));
    if (status == AL_OK) {
        const double floor[3] = {0.1 * s, -0.5 * s, 0.05 * s}, up[3] = {0, 1, 0}, out[3] = {7 * s, 3 * s, 0},
                     lamp[3] = {0, e->lamp_y * s, 0};
        const double *places[] = {floor, out, lamp};
        test.scratch = al_gather_scratch_new(test.gather);
        for (int i = 0; i < 3; i++) {
            al_gathered on = gather_at(&test, places[i], up, 3), in = gather_at(&test, places[i], NULL, 3);
            CHECK(is_good(&on));
            CHECK(is_good(&in));
        }
    }
    close_gather(&test);
}

int main(void)
{
    static const extreme cases[] = {
        {0.5, 1, 1, 0.1, 1, 0.1, 0}, /* an ordinary one */
        {0, 1, 1, 0.1, 1, 0, 0.99},        {1, 1, 1, 0.1, 0.5, 0, -0.99},
        {0.5, 1, 1, 0.1, 1e-6, 0, 0},      {0.5, 1, 1, 0.1, 0, 1e-6, 0},
        {0.5, 1, 1, 0.1, 1e4, 0, 0},       {0.5, 1, 1, 0.1, 0, 1e4, 0},
        {0.5, 1, 1e-4, 0.1, 1, 0.1, 0},    {0.5, 1, 1e4, 0.1, 1, 0.1, 0.5},
        {0.5, 1, 1, 0.5, 1, 0.1, 0}, /* the lamp on the box's lid */
        {0.5, 1e-6, 1, 0.1, 1, 0.1, 0},    {0.5, 1e6, 1, 0.1, 1, 0.1, 0},
        {1 - 1e-6, 1, 1, 0.1, 1, 1e-6, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        check_extreme(&cases[i], AL_WALLS_BOUNDED);
        check_extreme(&cases[i], AL_WALLS_TRACED);
    }
    return test_end();
}
