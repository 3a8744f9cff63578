/* The formulas that shaders use, as C: against libm and quadrature, with the errors their comments promise.
 */
#include "../test.h"
#include "airlight/formulas.h"

static void test_one_minus_exp(void)
{
    double worst = 0;
    for (double exponent = -12; exponent < 2; exponent += 0.001) {
        double x = pow(10, exponent), exact = -expm1(-x);
        worst = fmax(worst, fabs(al_one_minus_exp(x) / exact - 1));
    }
    CHECK_NEAR(worst, 0, 2e-9);
    CHECK(al_one_minus_exp(0.0) == 0);
    CHECK(al_one_minus_exp(1e4) == 1);
}

static void test_erf(void)
{
    double worst = 0;
    for (double x = -8; x <= 8; x += 1e-4) worst = fmax(worst, fabs(al_erf(x) - erf(x)));
    CHECK_NEAR(worst, 0, 3e-7);
    CHECK(al_erf(-1.5) == -al_erf(1.5));
    CHECK(al_erf(1e4) == 1);
}

static void test_gauss_span(void)
{
    double worst = 0, relative = 0;
    for (double from = -5; from < 5; from += 0.013)
        for (double exponent = -6; exponent < 1; exponent += 0.05) {
            double d = pow(10, exponent), to = from + d, middle = from + d / 2;
            /* The difference of erf loses digits below d of 1e-3: there the middle, good to d^2 / 12. */
            double exact = d > 1e-3 ? 0.886226925452758 * (erf(to) - erf(from)) : d * exp(-middle * middle);
            worst = fmax(worst, fabs(al_gauss_span(from, to) - exact));
            relative = fmax(relative, fabs(al_gauss_span(from, to) - exact) / d);
        }
    CHECK_NEAR(worst, 0, 6e-7);
    CHECK_NEAR(relative, 0, 4e-6);
}

/* Over all middles in the plane, at distance r from the foot: 2 pi r dr, by the midpoint rule over log r, whose ends leave out 1e-8
 * of it. On the axis a disc's own solid angle; far away A h/d^3. */
static void test_disc_angle(void)
{
    const double area = 0.02, radius = sqrt(area / AL_PI);
    for (double height = 0; height < 2; height = height > 0 ? 3 * height : 1e-4) {
        double sum = 0, step = 1e-4;
        for (double e = -12; e < 20; e += step) { /* r = exp e */
            double r = exp(e + step / 2);
            sum += 2 * AL_PI * r * r * step * al_disc_angle(area, height, r * r + height * height);
        }
        CHECK_NEAR(sum / area, 2 * AL_PI, 1e-4);
        double on_axis = 2 * AL_PI * (1 - height / sqrt(height * height + radius * radius));
        CHECK_NEAR(al_disc_angle(area, height, fmax(height * height, 1e-30)), on_axis, 1e-9);
    }
    CHECK_NEAR(al_disc_angle(area, 30, 2500) / (area * 30 / 125e3), 1, 1e-4);
    CHECK(al_disc_angle(0.0, 0.0, 1e-30) == 0);
}

int main(void)
{
    test_disc_angle();
    test_one_minus_exp();
    test_erf();
    test_gauss_span();
    return test_end();
}
