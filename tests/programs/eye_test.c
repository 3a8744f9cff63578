/* The player's camera, subpixel jitter and tone curve. */
#include <string.h>

#include "eye.h"
#include "test.h"
#include "tone_map.h"

static const al_bounds unit_box = {{-1, -1, -1}, {1, 1, 1}};

/* Clip-space position of a world point. */
static void project(const al_view *view, const float point[3], double clip[4])
{
    double seen[4];
    for (int row = 0; row < 4; row++) {
        const float *m = view->view + row;
        seen[row] = m[0] * point[0] + m[4] * point[1] + m[8] * point[2] + m[12];
    }
    for (int row = 0; row < 4; row++) {
        const float *m = view->projection + row;
        clip[row] = m[0] * seen[0] + m[4] * seen[1] + m[8] * seen[2] + m[12] * seen[3];
    }
}

static al_eye make_eye(float x, float y, float z)
{
    al_camera camera = {.name = "", .position = {x, y, z}, .up = {0, 1, 0}, .fov_y_radians = 0.7f};
    return al_eye_from_camera(&camera);
}

/* The target lies in the middle of the picture, whatever the way of looking, straight down included; the
 * whole box lies between the planes. Bounds: float matrices of numbers near one, 1e-5. */
static void test_view(void)
{
    static const float places[][3] = {{0, 0, 4}, {3, 2, 1}, {0, 5, 0}, {0, -5, 0}, {-2, 0.5f, -3}};
    const float centre[2] = {0, 0}, target[3] = {0, 0, 0};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        al_eye eye = make_eye(places[i][0], places[i][1], places[i][2]);
        al_view view = al_eye_view(&eye, &unit_box, centre, 640, 360);
        double clip[4];
        project(&view, target, clip);
        CHECK_NEAR(clip[0] / clip[3], 0, 1e-5);
        CHECK_NEAR(clip[1] / clip[3], 0, 1e-5);
        for (int corner = 0; corner < 8; corner++) {
            const float point[3] = {corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1};
            project(&view, point, clip);
            CHECK(fabs(clip[2]) <= clip[3]);
        }
    }
}

/* A point half a picture up and right moves by the offset, in pixels. */
static void test_offset(void)
{
    const float centre[2] = {0, 0}, offset[2] = {0.25f, -0.5f}, point[3] = {0.3f, 0.4f, -0.2f};
    al_eye eye = make_eye(0, 0, 4);
    al_view still = al_eye_view(&eye, &unit_box, centre, 640, 360),
            moved = al_eye_view(&eye, &unit_box, offset, 640, 360);
    double a[4], b[4];
    project(&still, point, a);
    project(&moved, point, b);
    /* float matrix entries near 2, picture coordinates of 320 pixels: 320 * 2^-22 */
    CHECK_NEAR((b[0] / b[3] - a[0] / a[3]) * 320, -offset[0], 1e-3);
    CHECK_NEAR((b[1] / b[3] - a[1] / a[3]) * 180, -offset[1], 1e-3);
}

/* One frame is the pixel's centre. 256 frames fall into a 4 x 4 grid of the pixel more evenly than random ones do: random
 * counts of mean 16 scatter by sqrt(16 * 15 / 16) = 3.9, the worst of sixteen by about 7; at most 2 are allowed here, as columns
 * hold 64 frames each and, in a column, multiples of the golden ratio are within 2 of their share of any interval at that length.
 * The mean, which would shift the picture, is none but for rounding. */
static void test_jitter(void)
{
    float centre[2];
    al_jitter(0, 1, centre);
    CHECK(centre[0] == 0 && centre[1] == 0);
    for (unsigned count = 2; count <= 256; count++) {
        int cells[16] = {0};
        double mean[2] = {0, 0};
        for (unsigned i = 0; i < count; i++) {
            float offset[2];
            al_jitter(i, count, offset);
            CHECK(fabsf(offset[0]) <= 0.5f && fabsf(offset[1]) <= 0.5f);
            for (int k = 0; k < 2; k++) mean[k] += offset[k] / count;
            cells[(int)(4 * fminf(offset[0] + 0.5f, 0.999f)) + 4 * (int)(4 * fminf(offset[1] + 0.5f, 0.999f))]++;
        }
        CHECK_NEAR(mean[0], 0, 1e-7);
        CHECK_NEAR(mean[1], 0, 1e-7);
        for (int i = 0; i < 16 && count == 256; i++) CHECK_NEAR(cells[i], 16, 2);
    }
}

/* Orbiting keeps the distance, stops before the poles and comes back; looking moves the target alone. */
static void test_moves(void)
{
    al_eye eye = make_eye(3, 0, 0);
    al_eye_orbit(&eye, 0.5f, 0);
    CHECK_NEAR(eye.position[0], 3 * cos(0.5), 1e-5);
    CHECK_NEAR(fabs(eye.position[2]), 3 * sin(0.5), 1e-5);
    for (int i = 0; i < 100; i++) al_eye_orbit(&eye, 0, 1);
    double distance = sqrt(eye.position[0] * eye.position[0] + eye.position[1] * eye.position[1] +
                           eye.position[2] * eye.position[2]);
    CHECK_NEAR(distance, 3, 1e-3);
    CHECK_NEAR(fabs(eye.position[1]), 3 * cos(3.14159265 / 180), 1e-3);
    al_eye looking = eye;
    al_eye_look(&looking, 0.3f, 0);
    CHECK(!memcmp(looking.position, eye.position, sizeof eye.position));
    CHECK(memcmp(looking.target, eye.target, sizeof eye.target));
    al_eye_zoom(&eye, 0.5f);
    CHECK_NEAR(sqrt(eye.position[0] * eye.position[0] + eye.position[1] * eye.position[1] +
                    eye.position[2] * eye.position[2]),
               1.5, 1e-3);
}

/* Straight up to the knee, monotone, of slope one where the parts meet, below 1 for everything finite that
 * float can tell from it. */
static void test_tone(void)
{
    float before = -1;
    for (int i = 0; i <= 4000; i++) {
        float x = 0.001f * (float)i, y = al_tone_map(x);
        CHECK(y >= before && y <= 1);
        if (x <= 0.6f) CHECK(y == x);
        before = y;
    }
    CHECK_NEAR((al_tone_map(0.601f) - al_tone_map(0.6f)) / 0.001, 1,
               0.002); /* second order: 0.001 / (2 * 0.4) */
    CHECK(al_tone_map(1e30f) == 1);
}

int main(void)
{
    test_view();
    test_offset();
    test_jitter();
    test_moves();
    test_tone();
    return test_end();
}
