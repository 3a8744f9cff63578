/* Motion against closed forms in double. Keys are binary fractions, so that a value at or between them is exact up to
 * the rounding of a few products: 1e-12 is 4500 times the epsilon of 1. What goes through floats (instances, lights,
 * cameras, vertices) is held to 1e-6, eight epsilons of a float at 1 to 2. */
#include "airlight/scene.h"

#include <math.h>
#include <string.h>

#include "../test.h"
#include "golden_data.h"

static const double exact = 1e-12, rounded = 1e-6;

static void check_at(const al_motion_channel *c, double time_s, const double *wanted)
{
    double value[16];
    al_motion_channel_at(c, time_s, value);
    for (uint32_t i = 0; i < c->width; i++) CHECK_NEAR(value[i], wanted[i], exact);
}

static void test_step_and_linear(void)
{
    float times[] = {1, 2, 4}, values[] = {1, 10, 0, 3, 20, 8, -1, 40, 16};
    al_motion_channel c = {0, AL_MOTION_TRANSLATION, AL_MOTION_LINEAR, 3, 3, times, values};
    check_at(&c, -5, (double[]){1, 10, 0});
    check_at(&c, 1, (double[]){1, 10, 0});
    check_at(&c, 1.25, (double[]){1.5, 12.5, 2});
    check_at(&c, 2, (double[]){3, 20, 8});
    check_at(&c, 3.5, (double[]){0, 35, 14});
    check_at(&c, 4, (double[]){-1, 40, 16});
    check_at(&c, 1e9, (double[]){-1, 40, 16});
    c.interpolation = AL_MOTION_STEP;
    check_at(&c, 0.5, (double[]){1, 10, 0});
    check_at(&c, 1.999, (double[]){1, 10, 0});
    check_at(&c, 2, (double[]){3, 20, 8});
    check_at(&c, 3.999, (double[]){3, 20, 8});
    check_at(&c, 4, (double[]){-1, 40, 16});
}

/* A Hermite spline reproduces every cubic: here f(t) = t^3 - 2t^2 + 3t - 1 between keys at 0.5, 1.5 and 4. */
static double cubic(double t)
{
    return ((t - 2) * t + 3) * t - 1;
}

static double slope(double t)
{
    return (3 * t - 4) * t + 3;
}

static void test_cubic(void)
{
    float times[] = {0.5f, 1.5f, 4}, values[9];
    for (int k = 0; k < 3; k++) {
        values[3 * k] = values[3 * k + 2] = (float)slope(times[k]);
        values[3 * k + 1] = (float)cubic(times[k]);
    }
    al_motion_channel c = {0, AL_MOTION_WEIGHTS, AL_MOTION_CUBIC, 3, 1, times, values};
    for (double t = 0.5; t <= 4; t += 0.125) {
        double value;
        al_motion_channel_at(&c, t, &value);
        CHECK_NEAR(value, cubic(t), 1e-11); /* numbers up to 43 */
    }
    check_at(&c, 0, (double[]){cubic(0.5)});
    check_at(&c, 5, (double[]){cubic(4)});
}

/* About one axis slerp turns evenly: at t the angle is (1 - t) a + t b. Quaternions of floats have a length of 1
 * within 1e-7, which slerp takes out; their angle is off by as much. */
static void check_turn(double from, double to, double sign, double t, double wanted)
{
    float times[] = {0, 2};
    float values[] = {0, (float)sin(from / 2), 0, (float)cos(from / 2), 0, (float)(sign * sin(to / 2)), 0,
                      (float)(sign * cos(to / 2))};
    al_motion_channel c = {0, AL_MOTION_ROTATION, AL_MOTION_LINEAR, 2, 4, times, values};
    double q[4];
    al_motion_channel_at(&c, 2 * t, q);
    double align = q[1] * sin(wanted / 2) + q[3] * cos(wanted / 2);
    CHECK_NEAR(fabs(align), 1, 1e-13);
    CHECK_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, exact);
    CHECK_NEAR(q[1] * cos(wanted / 2) - q[3] * sin(wanted / 2), 0, 2e-7);
}

static void test_slerp(void)
{
    for (double t = 0; t <= 1; t += 0.0625) {
        check_turn(0.25, 1.75, 1, t, 0.25 + 1.5 * t);
        check_turn(0.25, 1.75, -1, t, 0.25 + 1.5 * t); /* -q is the same turn: the shorter arc */
        check_turn(1, 1 + 1e-9, 1, t, 1);              /* hardly apart: a straight line */
        check_turn(0.5, 0.5, 1, t, 0.5);
        check_turn(-1, 3.14159265358979 - 1.001, 1, t, -1 + 3.14059265358979 * t); /* nearly half a turn */
    }
    /* A quaternion without length turns nothing; longer ones are as good as unit ones. */
    float time = 0, zero[] = {0, 0, 0, 0}, twice[] = {0, 0, 2, 0};
    al_motion_channel c = {0, AL_MOTION_ROTATION, AL_MOTION_LINEAR, 1, 4, &time, zero};
    check_at(&c, 0, (double[]){0, 0, 0, 1});
    c.values = twice;
    check_at(&c, 0, (double[]){0, 0, 1, 0});
}

static void test_loop(void)
{
    CHECK(al_motion_loop_s(0, 2) == 0 && al_motion_loop_s(1.5, 2) == 1.5 && al_motion_loop_s(2, 2) == 0);
    CHECK(al_motion_loop_s(7, 2) == 1 && al_motion_loop_s(-0.5, 2) == 1.5 && al_motion_loop_s(-4, 2) == 0);
    CHECK(al_motion_loop_s(-1e-300, 2) == 0 && al_motion_loop_s(3, 0) == 0 && al_motion_loop_s(NAN, 2) == 0);
    CHECK(al_motion_loop_s(INFINITY, 2) == 0 && al_motion_loop_s(1e18 + 1, 2) < 2);
    al_motion none = {0};
    CHECK(al_motion_length_s(&none) == 0);
    al_scene scene;
    golden_fill_moving_scene(&scene);
    CHECK(al_motion_length_s(&scene.motion) == 2);
}

static void check_matrix(const double m[16], const double wanted[16], double bound)
{
    for (int i = 0; i < 16; i++) CHECK_NEAR(m[i], wanted[i], bound);
}

/* The golden tree at 1.25 s: the root is moved by (1, 0, -1/2) inside its matrix, which doubles and moves by
 * (1/2, 0, 0); the hand is turned half about y (its last key), a unit above, and half as high. */
static void test_nodes(void)
{
    al_scene scene;
    double world[2][16], scratch[4];
    golden_fill_moving_scene(&scene);
    CHECK(al_motion_width(&scene.motion) == 4);
    al_motion_nodes_at(&scene.motion, 1.25, scratch, world);
    check_matrix(world[0], (double[]){2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 2.5, 0, -1, 1}, exact);
    check_matrix(world[1], (double[]){-2, 0, 0, 0, 0, 1, 0, 0, 0, 0, -2, 0, 2.5, 2, -1, 1}, exact);
    al_motion_place(&scene, (const double(*)[16])world);
    const float floor[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2.5f, -1, -1, 1};
    CHECK(!memcmp(scene.instances[0].world, floor, sizeof floor));
    CHECK_NEAR(scene.lights[1].vector[1], 2, rounded);
    /* The camera looked over a distance of sqrt(4 + 1.25^2 + 9), now along +z. */
    const al_camera *camera = &scene.cameras[0];
    CHECK_NEAR(camera->position[0], 2.5, rounded);
    CHECK_NEAR(camera->target[2] - camera->position[2], sqrt(4 + 1.25 * 1.25 + 9), 4 * rounded);
    CHECK_NEAR(camera->up[1], 1, rounded);
}

/* --- a bar of two bones along x: joints at 0 and 1, the second turned by an angle about z; the vertex at x hangs
 * with weight w on the second. Its place is (1-w) (x, y) + w ((1, 0) + R (x-1, y)) --- */

static void check_bar(double x, double y, double w, double angle)
{
    al_motion_node nodes[2] = {{"", AL_NO_INDEX, {0}, {0}, {0, 0, 0, 1}, {1, 1, 1}},
                               {"", 0, {0}, {1, 0, 0}, {0, 0, (float)sin(angle / 2), (float)cos(angle / 2)}, {1, 1, 1}}};
    al_motion_joint joints[2] = {{0, {0}}, {1, {0}}};
    float positions[3] = {(float)x, (float)y, 0}, normals[3] = {0, 1, 0}, weights[4] = {(float)(1 - w), (float)w, 0, 0};
    uint16_t hang[4] = {0, 1, 0, 0};
    double world[2][16], palette[2][16], scratch[4], c = cos(angle), s = sin(angle);
    float moved[3], turned[3];
    for (int i = 0; i < 16; i++)
        nodes[0].matrix[i] = nodes[1].matrix[i] = joints[0].inverse_bind[i] = joints[1].inverse_bind[i] = i % 5 == 0;
    joints[1].inverse_bind[12] = -1;
    al_motion m = {2, 0, 0, 2, 1, nodes, NULL, NULL, joints, NULL};
    al_motion_deform d = {.joint_count = 2, .node = AL_NO_INDEX, .bind_positions = positions, .bind_normals = normals,
                          .joints = hang, .weights = weights};
    al_motion_nodes_at(&m, 0, scratch, world);
    al_motion_palette(&m, &d, (const double(*)[16])world, palette);
    al_motion_deform_at(&d, 1, (const double(*)[16])palette, NULL, moved, turned);
    CHECK_NEAR(moved[0], (1 - w) * x + w * (1 + c * (x - 1) - s * y), rounded);
    CHECK_NEAR(moved[1], (1 - w) * y + w * (s * (x - 1) + c * y), rounded);
    CHECK_NEAR(moved[2], 0, rounded);
    /* The blended matrix is ((a, -b), (b, a)) with a = 1-w + w cos, b = w sin, and 1 along z: its cofactors turn
     * (0, 1) into (-b, a). */
    double a = 1 - w + w * c, b = w * s, length = sqrt(a * a + b * b);
    CHECK_NEAR(turned[0], -b / length, 2 * rounded);
    CHECK_NEAR(turned[1], a / length, 2 * rounded);
}

static void test_bar(void)
{
    for (double w = 0; w <= 1; w += 0.25)
        for (double angle = -2; angle <= 2; angle += 0.5) {
            check_bar(1.5, 0.25, w, angle);
            check_bar(0.25, -0.125, w, angle);
        }
}

static void test_morph(void)
{
    float positions[3] = {1, 2, 3}, normals[3] = {0, 0, 1}, deltas[6] = {1, 0, -2, 0, 4, 0}, bends[6] = {1, 0, 0, 0, 0, 0};
    float moved[3], turned[3];
    al_motion_deform d = {.target_count = 2, .node = AL_NO_INDEX, .has_normals = true, .bind_positions = positions,
                          .bind_normals = normals, .position_deltas = deltas, .normal_deltas = bends};
    for (int i = 0; i <= 2; i++) {
        double weights[2] = {0.5 * i, -0.25 * i};
        al_motion_deform_at(&d, 1, NULL, weights, moved, turned);
        CHECK_NEAR(moved[0], 1 + 0.5 * i, rounded);
        CHECK_NEAR(moved[1], 2 - i, rounded);
        CHECK_NEAR(moved[2], 3 - i, rounded);
        CHECK_NEAR(turned[0], 0.5 * i / sqrt(1 + 0.25 * i * i), rounded);
        CHECK_NEAR(turned[2], 1 / sqrt(1 + 0.25 * i * i), rounded);
    }
    al_scene scene;
    double weight;
    golden_fill_moving_scene(&scene);
    al_motion_weights_at(&scene.motion, &scene.motion.deforms[0], 0.99, &weight);
    CHECK(weight == 0);
    al_motion_weights_at(&scene.motion, &scene.motion.deforms[0], 1, &weight);
    CHECK(weight == 0.75);
    CHECK(al_motion_moves(&scene.motion, 0) && !al_motion_moves(&scene.motion, 1) && al_motion_moves(&scene.motion, 3));
}

/* A node scaled to nothing, or beyond all floats, leaves what hangs on it where it was. */
static void test_extremes(void)
{
    al_scene scene;
    golden_fill_moving_scene(&scene);
    float before[16];
    al_camera camera = scene.cameras[0];
    double world[2][16] = {{0}};
    memcpy(before, scene.instances[0].world, sizeof before);
    for (int i = 0; i < 2; i++) world[i][15] = 1, world[i][0] = 1e300, world[i][12] = i ? 0 : 1e200;
    al_motion_place(&scene, (const double(*)[16])world);
    CHECK(!memcmp(before, scene.instances[0].world, sizeof before));
    CHECK(!memcmp(camera.target, scene.cameras[0].target, sizeof camera.target));
}

int main(void)
{
    test_step_and_linear();
    test_cubic();
    test_slerp();
    test_loop();
    test_nodes();
    test_bar();
    test_morph();
    test_extremes();
    return test_end();
}
