/* The smallest test frame: CHECK counts and prints what failed; a test program returns test_end(). Exit code
 * 77 means SKIP to ctest (SKIP_RETURN_CODE). */
#ifndef AIRLIGHT_TEST_H
#define AIRLIGHT_TEST_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static int test_checks, test_failures;

#define CHECK(condition) \
    do { \
        test_checks++; \
        if (!(condition)) { \
            test_failures++; \
            fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
        } \
    } while (0)

/* |value - expected| <= bound; says all three when not. NaN fails. */
#define CHECK_NEAR(value, expected, bound) \
    do { \
        double value_ = (value), expected_ = (expected), bound_ = (bound); \
        test_checks++; \
        if (!(fabs(value_ - expected_) <= bound_)) { \
            test_failures++; \
            fprintf(stderr, "%s:%d: %s is %.9g, expected %s = %.9g within %.3g\n", __FILE__, __LINE__, #value, \
                    value_, #expected, expected_, bound_); \
        } \
    } while (0)

/* A row of the table of extremes (scripts/extremes.sh, which lists them: `what` is one of its list), and its check: what came
 * out against a closed form or double precision, |value - expected| <= bound. The words say what was asked, of what. The row
 * has the difference and the bound, in brackets, relative where the bound is; absolute where it is a thousand times the value. */
__attribute__((format(printf, 5, 6))) static inline void test_extreme(const char *what, double value, double expected,
                                                                      double bound, const char *words, ...)
{
    const double off = fabs(value - expected), unit = bound < 1e3 * fabs(expected) ? fabs(expected) : 1;
    const int right = off <= bound;
    va_list list;
    test_checks++;
    test_failures += !right;
    printf("extreme: | %s | ", what);
    va_start(list, words);
    vprintf(words, list);
    va_end(list);
    printf(" | %.6g | %.6g | ", value, expected);
    if (off == 0 && bound == 0)
        printf("exact");
    else
        printf("%.1e (%.1e)", off / unit, bound / unit);
    printf(" |%s\n", right ? "" : " MISSED");
}

static inline int test_end(void)
{
    printf("%d checks, %d failed\n", test_checks, test_failures);
    return test_failures ? 1 : 0;
}

static inline int test_skip(const char *why)
{
    printf("SKIP: %s\n", why);
    return 77;
}

#endif
