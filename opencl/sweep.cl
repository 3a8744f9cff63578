/* What the steps that sweep share: the layout of a swept field and its interpolation.
 *
 * A direction w has a dominant axis a; the grid is stored as [v][a][u], u fastest, so that the next slice of
 * a ray is near in memory. Parallel
 * rays cross slice k (the plane through its voxel centres) at u = I + k su, v = J + k sv, with I and J whole
 * and su = w_u/w_a, sv = w_v/w_a in [-1, 1]. With k su = shift + fraction, all rays of a slice share their
 * fraction, so that reading the grid along the rays and reading the rays at the voxels are both bilinear
 * interpolations with weights that are constant in the slice: nothing is interpolated twice, shadows of
 * small things stay sharp over any distance. What belongs to the ray at (i + fraction_u, j + fraction_v) is
 * stored at column i, row j of its slice.
 *
 * Grids and fields are padded by zeros so that eight lanes can be read without asking: columns
 * -8 .. width - 9, rows -1 .. height - 2. */

/* shape: x = columns of the grid (nu), y = rows (nv), z = slices (na), w = padded columns (width) */
static inline size_t al_at(int4 shape, int u, int v, int a)
{
    return ((size_t)(v + 1) * (size_t)shape.z + (size_t)a) * (size_t)shape.w + (size_t)(u + 8);
}

/* From a place to the one in the next row, v + 1. */
static inline size_t al_row(int4 shape)
{
    return (size_t)shape.z * (size_t)shape.w;
}
