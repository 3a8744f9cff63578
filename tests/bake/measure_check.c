/* The error that an asset carries, against the closed form: measure_check RADIUS_M SIGMA_T FINE.air COARSE.air
 *
 * At x inside a homogeneous ball the path to its surface along w is -x.w + sqrt((x.w)^2 + R^2 - |x|^2). */
#include <math.h>
#include <stdlib.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/translucent.h"

enum { POINTS = 2000 };

static double uniform(void)
{
    static uint64_t state = 12345;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) * 0x1p-53;
}

static void draw(double radius, float position[3], float direction[3])
{
    double square, z = 2 * uniform() - 1, angle = 2 * AL_PI * uniform();
    do {
        square = 0;
        for (int i = 0; i < 3; i++) {
            position[i] = (float)(radius * (2 * uniform() - 1));
            square += (double)position[i] * position[i];
        }
    } while (square >= radius * radius);
    direction[0] = (float)(sqrt(1 - z * z) * cos(angle));
    direction[1] = (float)(sqrt(1 - z * z) * sin(angle));
    direction[2] = (float)z;
}

static double truth(double radius, double sigma_t, const float x[3], const float w[3])
{
    double along = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        along += (double)x[i] * w[i];
        square += (double)x[i] * x[i];
    }
    return exp(-sigma_t * (sqrt(along * along + radius * radius - square) - along));
}

/* The asset's own figure; checked against points of our own. */
static double check(const char *path, double radius, double sigma_t)
{
    al_file *file;
    al_error error = {0};
    al_measured said = {0};
    al_translucent_info info;
    double sum = 0, sum_of_squares = 0;
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK && al_measured_count(file) == 1);
    CHECK(al_measured_read(file, 0, &said, &error) == AL_OK && al_translucent_read(file, &info, &error) == AL_OK);
    for (int i = 0; i < POINTS; i++) {
        float position[3], direction[3], answer[3];
        uint32_t used;
        draw(radius, position, direction);
        CHECK(al_translucent_evaluate(file, &info, position, direction, answer, &used, &error) == AL_OK);
        double square = pow(answer[0] - truth(radius, sigma_t, position, direction), 2);
        sum += square;
        sum_of_squares += square * square;
    }
    al_file_close(file);
    /* Two means of the same squares differ by less than four standard errors. Besides, the mesh lies up to
     * 2e-4 R inside the ball; where rays leave at a slant the path differs by more, in the mean square by less
     * than ten times that. */
    double mean = sum / POINTS, deviation = sqrt(sum_of_squares / POINTS - mean * mean),
           slack = 4 * deviation * sqrt(1.0 / POINTS + 1.0 / said.count), mesh = 2e-3 * sigma_t * radius;
    printf("%s: says %.5f of %u, closed form %.5f\n", path, said.rmse, said.count, sqrt(mean));
    CHECK(said.rmse > sqrt(fmax(0, mean - slack)) - mesh && said.rmse < sqrt(mean + slack) + mesh);
    CHECK(said.standard_error == 0 && said.largest >= said.rmse && said.count == 1024);
    return said.rmse;
}

int main(int argc, char **argv)
{
    if (argc != 5) return 2;
    double radius = atof(argv[1]), sigma_t = atof(argv[2]);
    double fine = check(argv[3], radius, sigma_t), coarse = check(argv[4], radius, sigma_t);
    CHECK(coarse > 1.5 * fine);
    return test_end();
}
