#include "matrix.h"

#include <math.h>
#include <string.h>

void al_matrix_from_float(const float *m, double *out)
{
    for (int i = 0; i < 16; i++) out[i] = m[i];
}

void al_matrix_to_float(const double *m, float *out)
{
    for (int i = 0; i < 16; i++) out[i] = (float)m[i];
}

void al_matrix_multiply(const double *a, const double *b, double *out)
{
    double product[16];
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0;
            for (int k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
            product[4 * column + row] = sum;
        }
    memcpy(out, product, sizeof product);
}

void al_matrix_transform(const double *m, const double *v, double *out)
{
    double result[4];
    for (int row = 0; row < 4; row++)
        result[row] = m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * v[3];
    memcpy(out, result, sizeof result);
}

/* Gauss-Jordan elimination with row pivoting. */
bool al_matrix_inverse(const double *m, double *out)
{
    double a[4][8] = {{0}};
    for (int row = 0; row < 4; row++) {
        for (int column = 0; column < 4; column++) a[row][column] = m[4 * column + row];
        a[row][4 + row] = 1;
    }
    for (int i = 0; i < 16; i++) out[i] = i % 5 == 0;
    for (int column = 0; column < 4; column++) {
        int pivot = column;
        for (int row = column + 1; row < 4; row++)
            if (fabs(a[row][column]) > fabs(a[pivot][column])) pivot = row;
        if (!(fabs(a[pivot][column]) > 1e-300) || !isfinite(a[pivot][column])) return false;
        for (int k = 0; k < 8; k++) {
            double swapped = a[column][k];
            a[column][k] = a[pivot][k];
            a[pivot][k] = swapped;
        }
        double scale = 1 / a[column][column];
        for (int k = 0; k < 8; k++) a[column][k] *= scale;
        for (int row = 0; row < 4; row++) {
            double factor = a[row][column];
            if (row == column) continue;
            for (int k = 0; k < 8; k++) a[row][k] -= factor * a[column][k];
        }
    }
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++) out[4 * column + row] = a[row][4 + column];
    return true;
}

bool al_matrix_is_rigid(const float *m, double tolerance)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot = 0;
            for (int k = 0; k < 3; k++) dot += (double)m[4 * i + k] * m[4 * j + k];
            if (!(fabs(dot - (i == j)) <= tolerance)) return false;
        }
    double determinant = m[0] * ((double)m[5] * m[10] - (double)m[6] * m[9]) -
                         m[4] * ((double)m[1] * m[10] - (double)m[2] * m[9]) +
                         m[8] * ((double)m[1] * m[6] - (double)m[2] * m[5]);
    return determinant > 0 && fabs(m[3]) + fabs(m[7]) + fabs(m[11]) + fabs(m[15] - 1) <= tolerance;
}
