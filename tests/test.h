/* The smallest test frame: CHECK counts and prints what failed; a test program returns test_end(). Exit code
 * 77 means SKIP to ctest (SKIP_RETURN_CODE). */
#ifndef AIRLIGHT_TEST_H
#define AIRLIGHT_TEST_H

#include <math.h>
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
