// A normal under a transform: by the cofactor matrix, the inverse's transpose times the determinant, whose sign alone matters.
// Right for every invertible transform.
vec3 turned_normal(mat3 m, vec3 normal)
{
    mat3 cofactor = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    return (dot(m[0], cofactor[0]) < 0.0 ? -1.0 : 1.0) * (cofactor * normal);
}
