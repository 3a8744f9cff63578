/* leave_out ERROR.exr OUT.exr: the standard errors of a view of the reference folder, NaN where the pixel's
 * ray passes within 0.15 m of the point light: there its glow has no bound, and airlight-compare leaves NaN
 * out. */
#include <math.h>
#include <stdio.h>

#include "airlight/image.h"

static double distance_from_light_m(double x, double y)
{
    static const double to_light[3] = {0.1, 0.55, 0.25 - 3.9};
    const double tangent = tan(39.3 / 2 / 57.29577951308232);
    double direction[3] = {(2 * x - 1) * tangent, (1 - 2 * y) * tangent, -1}, along = 0, square = 0,
           length = 0;
    for (int k = 0; k < 3; k++) {
        along += to_light[k] * direction[k];
        square += to_light[k] * to_light[k];
        length += direction[k] * direction[k];
    }
    return sqrt(square - along * along / length);
}

int main(int argc, char **argv)
{
    al_error error = {0};
    al_image image = {0};
    if (argc != 3) return 2;
    al_status status = al_image_read_exr(argv[1], &image, &error);
    for (uint32_t i = 0; !status && i < image.width * image.height; i++) {
        double x = (i % image.width + 0.5) / image.width, y = (i / image.width + 0.5) / image.height;
        for (uint32_t c = 0; c < image.channels && distance_from_light_m(x, y) < 0.15; c++)
            image.pixels[image.channels * i + c] = NAN;
    }
    if (!status) status = al_image_write_exr(argv[2], &image, &error);
    if (status) fprintf(stderr, "%s\n", error.message);
    al_image_free(&image);
    return status ? 1 : 0;
}
