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

int main(void)
{
    test_one_minus_exp();
    test_erf();
    test_gauss_span();
    return test_end();
}
