/* The view-dependent surfel cloud (Nalbach, Ritschel and Seidel 2014, with the surfelization of their 2015
 * paper): huge triangles are split, triangles become fine surfels, and fine surfels are thinned to the wanted
 * size, all on the GPU by tessellation and transform feedback. shaders/surfel*.* hold the steps.
 *
 * How many surfels there will be is known only when they are there. The buffer starts from the expected
 * number (surfel_count.c); the first frame, and one after a cut, waits for the count and goes again when
 * there was no room. Later frames look at counts that have come back, without waiting, and make room for the
 * next frame. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "airlight/formulas.h"
#include "matrix.h"
#include "state.h"

enum { VERTEX_SIZE = 24, FIRST_VERTICES = 3 << 12, ROUNDS = 3, ATTEMPTS = 8 };
enum { PARTS, SURFELS }; /* vertex streams, and indices of al_surfel_count */

static void cross(const float a[3], const float b[3], double out[3])
{
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = (double)a[i] * b[j] - (double)a[j] * b[i];
    }
}

/* The wanted area: a disc of so many pixels. A pixel is the parallelogram of the steps of the view's rays in
 * x and y: on the plane at 1 m for a perspective view, whose ray directions end on one plane. */
static al_surfel_rule make_rule(const al_draw *draw)
{
    const float(*ray)[4] = draw->block.ray;
    bool perspective = draw->eye[3] > 0;
    al_surfel_rule rule = {.nearest_m = 0};
    double across[3], size, away = 0, radius = draw->settings.surfel_pixels;
    cross(ray[perspective ? 4 : 1], ray[perspective ? 5 : 2], across);
    size = sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
    for (int k = 0; k < 3; k++) away += across[k] / size * ray[3][k];
    rule.area = AL_PI * radius * radius * size / (perspective ? away * away : 1);
    memcpy(rule.eye, draw->eye, sizeof rule.eye);
    double inverse[16], near[4] = {0, 0, -1, 1};
    if (!perspective || !al_matrix_inverse(draw->view_projection, inverse)) return rule;
    al_matrix_transform(inverse, near, near);
    for (int k = 0; k < 3; k++) rule.nearest_m += pow(near[k] / near[3] - rule.eye[k], 2);
    rule.nearest_m = sqrt(rule.nearest_m);
    return rule;
}

/* --- room --- */

static uint64_t surfel_limit(const al_draw *draw)
{
    GLint64 block = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    uint64_t most = (uint64_t)block / AL_SURFEL_SIZE;
    return draw->settings.surfel_limit < most ? draw->settings.surfel_limit : most;
}

static al_status resize(al_draw *draw, al_gl_buffer *buffer, GLuint *feedback, uint64_t size)
{
    al_gl_buffer_free(&draw->runtime->memory, buffer);
    if (!*feedback) glCreateTransformFeedbacks(1, feedback);
    al_status status = al_gl_buffer_create(&draw->runtime->memory, size, NULL, buffer, draw->error);
    if (!status) glTransformFeedbackBufferBase(*feedback, 0, buffer->id);
    return status;
}

static al_status resize_cloud(al_draw *draw, double surfels)
{
    al_surfels *s = &draw->runtime->surfels;
    double limit = (double)surfel_limit(draw);
    return resize(draw, &s->cloud, &s->cloud_feedback, (uint64_t)fmin(surfels, limit) * AL_SURFEL_SIZE);
}

static void describe_parts(GLuint array, GLuint buffer)
{
    glVertexArrayVertexBuffer(array, 0, buffer, 0, VERTEX_SIZE);
    glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribFormat(array, 2, 2, GL_FLOAT, GL_FALSE, 12);
    glVertexArrayAttribIFormat(array, 4, 1, GL_UNSIGNED_INT, 20);
    for (GLuint attribute = 0; attribute <= 4; attribute += 2) {
        glEnableVertexArrayAttrib(array, attribute);
        glVertexArrayAttribBinding(array, attribute, 0);
    }
}

static al_status resize_parts(al_draw *draw, uint64_t vertices)
{
    al_surfels *s = &draw->runtime->surfels;
    al_status status = AL_OK;
    for (int i = 0; i < 2 && !status; i++) {
        status = resize(draw, &s->parts[i], &s->parts_feedback[i], vertices * VERTEX_SIZE);
        if (!s->parts_array[i]) glCreateVertexArrays(1, &s->parts_array[i]);
        if (!status) describe_parts(s->parts_array[i], s->parts[i].id);
    }
    return status;
}

static void make_queries(al_surfels *s)
{
    for (int i = 0; i < AL_SURFEL_RING; i++) {
        glCreateQueries(GL_PRIMITIVES_GENERATED, 2, s->ring[i].wanted);
        glCreateQueries(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, 2, s->ring[i].written);
    }
}

/* The rule with surfels as coarse as the limit makes them. */
static void update_rule(al_draw *draw)
{
    al_surfels *s = &draw->runtime->surfels;
    s->rule = make_rule(draw);
    s->rule.area *= s->coarseness;
}

/* Coarser by what `surfels` at the present coarseness are beyond the limit, and a twentieth. */
static void coarsen(al_draw *draw, double surfels)
{
    al_surfels *s = &draw->runtime->surfels;
    double limit = (double)surfel_limit(draw);
    if (surfels <= limit) return;
    s->coarseness *= 1.05 * surfels / limit;
    glDebugMessageInsert(GL_DEBUG_SOURCE_APPLICATION, GL_DEBUG_TYPE_PERFORMANCE, 0, GL_DEBUG_SEVERITY_LOW, -1,
                         "surfels: there would be more than their limit, so they are larger");
    update_rule(draw);
}

/* The count's variance is at most its mean: five standard deviations, and a tenth for what moves. */
static al_status start(al_draw *draw)
{
    al_surfels *s = &draw->runtime->surfels;
    double expected = al_surfels_expected(&draw->runtime->scene, &s->rule), before = s->coarseness;
    for (int i = 0; i < AL_SURFEL_RING; i++) s->ring[i].pending = false; /* of another cloud */
    coarsen(draw, expected);
    expected *= before / s->coarseness;
    if (!s->count.id) {
        static const GLuint points[4] = {0, 1, 0, 0}; /* of which the capture fills in the first: an indirect draw */
        al_status status = al_gl_buffer_create(&draw->runtime->memory, sizeof points, points, &s->count, draw->error);
        if (status) return status;
        make_queries(s);
    }
    double surfels = 1.1 * expected + 5 * sqrt(expected) + 64;
    return surfels * AL_SURFEL_SIZE > (double)s->cloud.size ? resize_cloud(draw, surfels) : AL_OK;
}

/* A count has come back: makes room for as many, or surfels coarser; *short_of: there was no room. */
static al_status take_count(al_draw *draw, al_surfel_count *count, bool *short_of)
{
    al_surfels *s = &draw->runtime->surfels;
    GLuint64 wanted[2], written[2];
    al_status status = AL_OK;
    for (int i = 0; i < 2; i++) {
        glGetQueryObjectui64v(count->wanted[i], GL_QUERY_RESULT, &wanted[i]);
        glGetQueryObjectui64v(count->written[i], GL_QUERY_RESULT, &written[i]);
    }
    count->pending = false;
    s->drawn = written[SURFELS];
    *short_of = wanted[PARTS] > written[PARTS] || wanted[SURFELS] > written[SURFELS];
    if (wanted[PARTS] > written[PARTS] && wanted[PARTS] * VERTEX_SIZE > s->parts[0].size)
        status = resize_parts(draw, wanted[PARTS] + wanted[PARTS] / 4);
    double surfels = (double)wanted[SURFELS] * count->coarseness / s->coarseness;
    coarsen(draw, surfels);
    if (surfels * s->coarseness < 0.8 * (double)surfel_limit(draw)) s->coarseness = 1;
    if (!status && wanted[SURFELS] > written[SURFELS] && surfels * AL_SURFEL_SIZE > (double)s->cloud.size)
        status = resize_cloud(draw, surfels * 1.25);
    return status;
}

/* Takes what has come back of earlier frames. */
static al_status collect(al_draw *draw)
{
    al_surfels *s = &draw->runtime->surfels;
    al_status status = AL_OK;
    for (uint32_t i = 1; i <= AL_SURFEL_RING && !status; i++) { /* oldest first */
        al_surfel_count *count = &s->ring[(s->current + i) % AL_SURFEL_RING];
        GLuint available = 0;
        bool short_of;
        if (!count->pending) continue;
        glGetQueryObjectuiv(count->written[SURFELS], GL_QUERY_RESULT_AVAILABLE, &available);
        if (available) status = take_count(draw, count, &short_of);
    }
    return status;
}

/* --- capture --- */

static bool sends(const al_runtime *runtime, const al_instance *instance)
{
    return instance->role == AL_ROLE_OPAQUE && runtime->model.meshes[instance->mesh].vertex_array;
}

typedef struct programs {
    GLuint fine, split;
} programs;

static al_status get_programs(al_draw *draw, programs *p)
{
    al_shaders *shaders = draw->runtime->shaders;
    al_status status =
        al_shaders_get(shaders, "surfel.vert surfel.tesc surfel.tese surfel.geom",
                                      draw->settings.surfels_plain ? "#define AL_PLAIN\n" : "", &p->fine, draw->error);
    if (status) return status;
    return al_shaders_get(shaders, "surfel.vert surfel_split.tesc surfel_split.tese surfel_split.geom", "",
                          &p->split, draw->error);
}

/* Whether some triangle of the instance may have to be split: a bound by the mesh's longest edge and its box
 * of what surfel_size.glsl asks of each triangle, whose area is at most sqrt(3)/4 of its longest edge's
 * square. */
static bool may_be_huge(const al_runtime *runtime, const al_instance *instance, const al_surfel_rule *rule)
{
    const double most = 48; /* points at the highest level */
    float low[3], high[3];
    double stretch = 0, away = 0;
    for (int k = 0; k < 9; k++) stretch += pow(instance->world[k / 3 * 4 + k % 3], 2); /* Frobenius */
    double edge = runtime->model.meshes[instance->mesh].longest_edge * sqrt(stretch);
    double area = sqrt(3) / 4 * edge * edge;
    if (rule->eye[3] == 0) return area > 0.999 * most * rule->area;
    al_model_world_box(runtime, instance, low, high);
    for (int k = 0; k < 3; k++) {
        double off = fmax(fmax(low[k] - rule->eye[k], rule->eye[k] - high[k]), 0);
        away += off * off;
    }
    away = fmax(sqrt(away), rule->nearest_m);
    return edge > 0.999 * away || area > 0.999 * most * rule->area * away * away;
}

static bool any_huge(const al_runtime *runtime)
{
    bool huge = false;
    for (uint32_t i = 0; i < runtime->scene.instance_count && !huge; i++)
        huge = sends(runtime, &runtime->scene.instances[i]) &&
               may_be_huge(runtime, &runtime->scene.instances[i], &runtime->surfels.rule);
    return huge;
}

static void set_rule(GLuint program, const al_surfel_rule *rule)
{
    glProgramUniform2f(program, 6, (float)rule->area, (float)rule->nearest_m);
}

/* Triangles on their way: of the scene, or what a round of splitting made of them. */
typedef struct input {
    const float *world;
    GLint choice[3];               /* instance; 1 for parts; -1 where it mirrors, else 1 */
    GLuint vertex_array, feedback; /* feedback: that captured them; 0: the range of indices of `part` */
    const al_submesh *part;
} input;

static void draw_input(const input *in)
{
    glUniformMatrix4fv(0, 1, GL_FALSE, in->world);
    glUniform3iv(5, 1, in->choice);
    glBindVertexArray(in->vertex_array);
    if (in->feedback)
        glDrawTransformFeedback(GL_PATCHES, in->feedback);
    else
        glDrawElements(GL_PATCHES, (GLsizei)in->part->index_count, GL_UNSIGNED_INT,
                       (const void *)((uintptr_t)in->part->first_index * sizeof(uint32_t)));
}

/* The cloud's capture waits while the huge triangles among `in` are split; they are then to be gone on with.
 */
static void split(al_draw *draw, const programs *p, int round, input *in)
{
    static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const al_surfels *s = &draw->runtime->surfels;
    int to = round % 2;
    glPauseTransformFeedback();
    glUseProgram(p->split);
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, s->parts_feedback[to]);
    glBeginTransformFeedback(GL_POINTS);
    draw_input(in);
    glEndTransformFeedback();
    glUseProgram(p->fine);
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, s->cloud_feedback);
    glResumeTransformFeedback();
    in->world = identity;
    in->choice[1] = 1;
    in->vertex_array = s->parts_array[to];
    in->feedback = s->parts_feedback[to];
}

static void capture_instance(al_draw *draw, const programs *p, uint32_t index)
{
    const al_runtime *runtime = draw->runtime;
    const al_instance *instance = &runtime->scene.instances[index];
    const al_mesh *mesh = &runtime->scene.meshes[instance->mesh];
    GLuint vertex_array = runtime->model.meshes[instance->mesh].vertex_array;
    if (!sends(runtime, instance)) return;
    int rounds = !draw->settings.surfels_plain && may_be_huge(runtime, instance, &runtime->surfels.rule) ? ROUNDS : 0;
    for (uint32_t i = 0; i < mesh->submesh_count; i++) {
        const al_submesh *part = &mesh->submeshes[i];
        GLint mirrors = al_instance_mirrors(instance) ? -1 : 1;
        input in = {instance->world, {(GLint)index, 0, mirrors}, vertex_array, 0, part};
        if (!part->index_count) continue;
        al_material_bind(runtime, part);
        for (int round = 0; round <= rounds; round++) {
            glUniform1i(7, round < rounds);
            draw_input(&in);
            if (round < rounds) split(draw, p, round, &in);
        }
    }
}

static void capture(al_draw *draw, const programs *p)
{
    al_surfels *s = &draw->runtime->surfels;
    s->current = (s->current + 1) % AL_SURFEL_RING;
    al_surfel_count *count = &s->ring[s->current];
    set_rule(p->split, &s->rule);
    set_rule(p->fine, &s->rule);
    glProgramUniform1ui(p->fine, 8, draw->settings.surfel_seed);
    glProgramUniform1f(p->fine, 9, draw->settings.surfel_margin_m);
    glUseProgram(p->fine);
    glBindFramebuffer(GL_FRAMEBUFFER, draw->framebuffer); /* any complete one */
    glEnable(GL_RASTERIZER_DISCARD);
    for (GLuint i = 0; i < 2; i++) {
        glBeginQueryIndexed(GL_PRIMITIVES_GENERATED, i, count->wanted[i]);
        glBeginQueryIndexed(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, i, count->written[i]);
    }
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, s->cloud_feedback);
    glBeginTransformFeedback(GL_POINTS);
    for (uint32_t i = 0; i < draw->runtime->scene.instance_count; i++) capture_instance(draw, p, i);
    glEndTransformFeedback();
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
    for (GLuint i = 0; i < 2; i++) {
        glEndQueryIndexed(GL_PRIMITIVES_GENERATED, i);
        glEndQueryIndexed(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, i);
    }
    glDisable(GL_RASTERIZER_DISCARD);
    glGetQueryBufferObjectuiv(count->written[SURFELS], s->count.id, GL_QUERY_RESULT, 0);
    count->coarseness = s->coarseness;
    count->pending = true;
}

/* Whether there may be many more surfels than in the frame before, `rule` its rule: they are finer, or the
 * eye has moved by more than half of its distance to the box of all opaque instances (or, nearer than that, a
 * twentieth of the box), as it does when the view changes to another camera. */
static bool is_cut(const al_draw *draw, const al_surfel_rule *before)
{
    const al_runtime *runtime = draw->runtime;
    const al_surfel_rule *rule = &runtime->surfels.rule;
    double away = 0, extent = 0, moved = 0;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        float box[2][3];
        if (!sends(runtime, &runtime->scene.instances[i])) continue;
        al_model_world_box(runtime, &runtime->scene.instances[i], box[0], box[1]);
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], box[0][k]);
            high[k] = fmaxf(high[k], box[1][k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        away += pow(fmax(fmax(low[k] - before->eye[k], before->eye[k] - high[k]), 0), 2);
        extent += pow(high[k] - low[k], 2);
        moved += pow(rule->eye[k] - before->eye[k], 2);
    }
    bool perspective = rule->eye[3] > 0;
    return rule->area < 0.7 * before->area || rule->eye[3] != before->eye[3] ||
           (perspective && sqrt(moved) > 0.5 * fmax(sqrt(away), 0.05 * sqrt(extent)));
}

static al_status make_cloud(al_draw *draw)
{
    al_surfels *s = &draw->runtime->surfels;
    al_surfel_rule before = s->rule;
    programs p = {0};
    if (!(s->coarseness >= 1)) s->coarseness = 1;
    al_status status = s->cloud.id ? collect(draw) : AL_OK;
    update_rule(draw);
    bool settled = s->cloud.id && !is_cut(draw, &before);
    if (!status && !settled) status = start(draw);
    if (!status) status = get_programs(draw, &p);
    for (int attempt = 0; attempt < ATTEMPTS && !status; attempt++) {
        bool short_of = false;
        if (!s->parts[0].id && any_huge(draw->runtime)) status = resize_parts(draw, FIRST_VERTICES);
        if (status) break;
        capture(draw, &p);
        if (settled) break;
        status = take_count(draw, &s->ring[s->current], &short_of);
        if (!short_of) break;
        update_rule(draw);
    }
    return status;
}

al_status al_surfels_run(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_surfels *s = &runtime->surfels;
    if (!draw->needs_surfels) {
        al_surfels_free(runtime);
        return AL_OK;
    }
    al_timing_begin(&runtime->timing, AL_STAGE_SURFELS);
    al_status status = make_cloud(draw);
    al_timing_end(&runtime->timing);
    if (status) return status;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, s->cloud.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, s->count.id);
    return al_surfels_light(draw);
}

/* glDrawTransformFeedbackStream would do, but llvmpipe of Mesa 22.3 divides what was captured by the stride of whatever
 * vertex buffer was bound last, and draws surfels of an earlier frame too. */
void al_surfels_draw_points(const al_draw *draw)
{
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draw->runtime->surfels.count.id);
    glDrawArraysIndirect(GL_POINTS, NULL);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

uint64_t al_surfels_count(const al_runtime *runtime)
{
    const al_surfels *s = &runtime->surfels;
    const al_surfel_count *count = &s->ring[s->current];
    GLuint available = 0;
    GLuint64 written = s->drawn;
    if (count->pending) glGetQueryObjectuiv(count->written[SURFELS], GL_QUERY_RESULT_AVAILABLE, &available);
    if (available) glGetQueryObjectui64v(count->written[SURFELS], GL_QUERY_RESULT, &written);
    return written;
}

uint64_t al_surfels_bytes(const al_runtime *runtime)
{
    const al_surfels *s = &runtime->surfels;
    return s->cloud.size + s->parts[0].size + s->parts[1].size + s->count.size;
}

void al_surfels_free(al_runtime *runtime)
{
    al_surfels *s = &runtime->surfels;
    al_gl_buffer_free(&runtime->memory, &s->cloud);
    al_gl_buffer_free(&runtime->memory, &s->count);
    if (s->cloud_feedback) glDeleteTransformFeedbacks(1, &s->cloud_feedback);
    for (int i = 0; i < 2; i++) {
        al_gl_buffer_free(&runtime->memory, &s->parts[i]);
        if (s->parts_feedback[i]) glDeleteTransformFeedbacks(1, &s->parts_feedback[i]);
        if (s->parts_array[i]) glDeleteVertexArrays(1, &s->parts_array[i]);
    }
    for (int i = 0; i < AL_SURFEL_RING && s->ring[0].wanted[0]; i++) {
        glDeleteQueries(2, s->ring[i].wanted);
        glDeleteQueries(2, s->ring[i].written);
    }
    memset(s, 0, sizeof *s);
}
