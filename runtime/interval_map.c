/* The view's transmittance interval map, and what the passes that splat onto it share. */
#include <math.h>
#include <string.h>

#include "airlight/formulas.h"
#include "state.h"

static bool same(float a, float b)
{
    return fabsf(a - b) <= 1e-6f * fmaxf(fabsf(a), fabsf(b));
}

/* Whether extinction is grey and all media share one albedo and one g, which go to `medium`. */
static bool one_medium(const al_fog_block *fogs, float medium[4])
{
    bool first = true;
    for (int32_t i = 0; i < fogs->counts[0]; i++) {
        const al_fog_entry *fog = &fogs->fogs[i];
        if (fog->sigma_t[0] == 0 && fog->sigma_t[1] == 0 && fog->sigma_t[2] == 0) continue;
        if (!same(fog->sigma_t[0], fog->sigma_t[1]) || !same(fog->sigma_t[0], fog->sigma_t[2])) return false;
        float own[4] = {fog->sigma_s[0] / fog->sigma_t[0], fog->sigma_s[1] / fog->sigma_t[1],
                        fog->sigma_s[2] / fog->sigma_t[2], fog->sigma_t[3]};
        for (int k = 0; k < 4 && !first; k++)
            if (!same(own[k], medium[k])) return false;
        memcpy(medium, own, sizeof own);
        first = false;
    }
    return true;
}

/* The published coefficients are grey: their tint, relative to the mean that the map stores, and the mean g. */
static void mean_medium(const al_fog_block *fogs, float medium[4])
{
    double sum[4] = {0};
    for (int32_t i = 0; i < fogs->counts[0]; i++) {
        const al_fog_entry *fog = &fogs->fogs[i];
        for (int k = 0; k < 3; k++) {
            sum[k] += fog->sigma_s[k] * fog->sigma_s[3];
            sum[3] += fog->sigma_s[k] * fog->sigma_s[3] * fog->sigma_t[3];
        }
    }
    double mean = (sum[0] + sum[1] + sum[2]) / 3;
    for (int k = 0; k < 3; k++) medium[k] = mean > 0 ? (float)(sum[k] / mean) : 0;
    medium[3] = mean > 0 ? (float)(sum[3] / (3 * mean)) : 0;
}

/* One cell where all media are constant along every ray, a grid's march step where there are grids, else what
 * resolves the smallest box. */
static float cell_of(const al_fog_block *fogs)
{
    bool constant = true, bounded = false;
    float grid = INFINITY, box = INFINITY;
    for (int32_t i = 0; i < fogs->counts[0]; i++) {
        const al_fog_entry *fog = &fogs->fogs[i];
        if (fog->cells[0]) grid = fminf(grid, fog->march[0]);
        constant = constant && !fog->cells[0];
        if (fog->low[3] == 0) continue;
        bounded = true;
        for (int k = 0; k < 3; k++) box = fminf(box, fog->extent[k] / 32);
    }
    if (constant && (fogs->counts[0] == 1 || !bounded)) return 0;
    return fminf(grid, box);
}

/* The largest value of the media's phase functions, which lies at cosine +-1 for either sign of g. */
static float largest_phase(const al_fog_block *fogs)
{
    double largest = 0;
    for (int32_t i = 0; i < fogs->counts[0]; i++)
        largest = fmax(largest, al_phase(fabs((double)fogs->fogs[i].sigma_t[3]), 1));
    return (float)largest;
}

al_status al_shells_prepare(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_shells *shells = &runtime->shells;
    const al_settings *settings = &draw->settings;
    al_shell_block *block = &shells->block;
    const al_fog_block *fogs = &runtime->fogs.block;
    *block = (al_shell_block){
        .counts = {(int32_t)settings->shell_levels, (int32_t)settings->interval_count - 1,
                   (int32_t)runtime->frame_number, 0},
        .reach = {settings->shell_epsilon_w_m2_sr, settings->shell_radius_m, largest_phase(fogs),
                  settings->shells_closed ? 0 : 1},
        .blur = {settings->blur_off ? -1 : (int32_t)settings->blur_mips, !settings->blur_plain,
                 settings->shells_clamped, settings->interval_jitter_off}};
    shells->weighing = settings->interval_weights;
    if (shells->weighing == AL_INTERVAL_WEIGHTS_COEFFICIENTS && settings->visibility)
        shells->weighing = AL_INTERVAL_WEIGHTS_AUTO; /* rays are drawn among samples of equal weight */
    if (shells->weighing == AL_INTERVAL_WEIGHTS_COEFFICIENTS)
        mean_medium(fogs, block->medium);
    else if (!one_medium(fogs, block->medium))
        shells->weighing = AL_INTERVAL_WEIGHTS_COLOURED;
    shells->cell_m = cell_of(fogs);
    al_status status = al_gl_buffer_fit(&runtime->memory, sizeof *block, &shells->constants, draw->error);
    if (status || !draw->needs_surfels || settings->visibility || settings->second_leg_off) return status;
    return al_legs_run(draw);
}

const char *al_interval_map_define(const al_runtime *runtime)
{
    switch (runtime->shells.weighing) {
    case AL_INTERVAL_WEIGHTS_COLOURED: return "#define AL_WEIGHTS\n";
    case AL_INTERVAL_WEIGHTS_COEFFICIENTS: return "#define AL_COEFFICIENTS\n";
    default: return "";
    }
}

static al_status fit(al_draw *draw)
{
    al_shells *shells = &draw->runtime->shells;
    al_gl_memory *memory = &draw->runtime->memory;
    uint32_t width = (uint32_t)draw->tile[2], height = (uint32_t)draw->tile[3];
    uint32_t samples = (uint32_t)shells->block.counts[1], layers = (samples + 15) / 16;
    al_status status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_RGBA32UI, width, height, layers,
                                         &shells->steps, draw->error);
    if (!status)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D, GL_RGBA32F, width, height, 1, &shells->ends,
                                   draw->error);
    if (!status && shells->weighing == AL_INTERVAL_WEIGHTS_COLOURED)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_RGBA8, width, height, samples,
                                   &shells->weights, draw->error);
    if (!status && shells->weighing == AL_INTERVAL_WEIGHTS_COEFFICIENTS)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_RGBA32UI, width, height, layers,
                                   &shells->weights, draw->error);
    return status;
}

/* Levels are padded so that every block is whole, and of the coarsest mip that is read too. */
static void fill_tile(al_draw *draw)
{
    al_shells *shells = &draw->runtime->shells;
    int32_t blocks = shells->block.counts[0] - 1, blur = shells->block.blur[0] > 0 ? shells->block.blur[0] : 0,
            mips = draw->settings.visibility ? (blur > blocks ? blur : blocks) : blocks + blur, edge = 1 << mips;
    for (int k = 0; k < 2; k++) {
        shells->block.size[k] = (draw->tile[2 + k] + edge - 1) / edge * edge;
        shells->block.size[2 + k] = draw->tile[2 + k];
    }
    glNamedBufferSubData(shells->constants.id, 0, sizeof shells->block, &shells->block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 3, shells->constants.id);
}

al_status al_interval_map_run(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_shells *shells = &runtime->shells;
    GLuint program;
    al_status status = fit(draw);
    if (!status)
        status = al_shaders_get(runtime->shaders, "interval_map.comp", al_interval_map_define(runtime), &program,
                                draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_INTERVAL_MAP);
    fill_tile(draw);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->targets.geometry.id);
    glBindImageTexture(0, shells->steps.id, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
    glBindImageTexture(1, shells->ends.id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    if (shells->weighing != AL_INTERVAL_WEIGHTS_AUTO)
        glBindImageTexture(2, shells->weights.id, 0, GL_TRUE, 0, GL_WRITE_ONLY, shells->weights.format);
    glUniform1f(0, shells->cell_m);
    glDispatchCompute(((GLuint)draw->tile[2] + 7) / 8, ((GLuint)draw->tile[3] + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

void al_shells_sweep(al_runtime *runtime)
{
    al_shells *shells = &runtime->shells;
    al_gl_texture *const textures[] = {&shells->steps, &shells->ends,   &shells->weights,
                                       &shells->span,  &shells->levels, &shells->light};
    for (size_t i = 0; i < sizeof textures / sizeof textures[0]; i++)
        al_gl_texture_sweep(&runtime->memory, textures[i]);
    al_gl_buffer_sweep(&runtime->memory, &shells->constants);
    al_gl_framebuffer_sweep(&shells->framebuffer, &shells->levels);
}

uint64_t al_interval_map_bytes(const al_runtime *runtime)
{
    const al_shells *shells = &runtime->shells;
    return shells->steps.bytes + shells->ends.bytes + shells->weights.bytes + shells->constants.size;
}

uint64_t al_shells_bytes(const al_runtime *runtime)
{
    const al_shells *shells = &runtime->shells;
    return shells->span.bytes + shells->levels.bytes + shells->light.bytes + runtime->legs.extinction.bytes +
           runtime->legs.constants.size + runtime->fogs.depth.bytes;
}
