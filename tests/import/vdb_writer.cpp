#include "vdb_writer.h"

#include <openvdb/openvdb.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

namespace
{

openvdb::math::Transform::Ptr make_transform(const vdb_grid &from)
{
    if (from.kind == VDB_FRUSTUM)
        return openvdb::math::Transform::createFrustumTransform(
            openvdb::BBoxd(openvdb::Vec3d(0, 0, 0), openvdb::Vec3d(8, 8, 8)), 0.5, 1.0, 1.0);
    if (from.index_to_world[15] == 0) return openvdb::math::Transform::createLinearTransform(1.0);
    openvdb::math::Mat4d matrix; /* OpenVDB multiplies row vectors: our columns are its rows */
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++)
            matrix(row, column) = from.index_to_world[row * 4 + column];
    return openvdb::math::Transform::createLinearTransform(matrix);
}

template <typename Grid>
openvdb::GridBase::Ptr make(const vdb_grid &from, const typename Grid::ValueType &background)
{
    typename Grid::Ptr grid = Grid::create(background);
    auto voxels = grid->getAccessor();
    const int last = from.size[0] * from.size[1] * from.size[2] - 1;
    for (int i = 0; i <= last; i += from.kind == VDB_CORNERS ? last : 1) {
        const openvdb::Coord at(from.first[0] + i % from.size[0],
                                from.first[1] + i / from.size[0] % from.size[1],
                                from.first[2] + i / (from.size[0] * from.size[1]));
        voxels.setValue(at, typename Grid::ValueType(from.values ? from.values[i] : 1.0f));
    }
    grid->setName(from.name);
    grid->setTransform(make_transform(from));
    grid->setSaveFloatAsHalf(from.kind == VDB_HALF);
    grid->setGridClass(from.kind == VDB_LEVEL_SET ? openvdb::GRID_LEVEL_SET : openvdb::GRID_FOG_VOLUME);
    return grid;
}

} // namespace

void vdb_write(const char *path, const vdb_grid *grids, int count)
{
    try {
        openvdb::initialize();
        openvdb::GridPtrVec made;
        for (int i = 0; i < count; i++)
            made.push_back(grids[i].kind == VDB_VECTOR
                               ? make<openvdb::Vec3SGrid>(grids[i], openvdb::Vec3f(0))
                               : make<openvdb::FloatGrid>(grids[i], grids[i].background));
        openvdb::io::File(path).write(made);
    } catch (const std::exception &problem) {
        std::fprintf(stderr, "%s: %s\n", path, problem.what());
        std::exit(1);
    }
}

void vdb_write_speck(const char *path, int count, double edge_m, float speck, float rest)
{
    const double voxel_m = edge_m / count;
    std::vector<float> values(static_cast<size_t>(count) * count * count, rest);
    values[values.size() / 2] = speck;
    vdb_grid grid = {};
    grid.name = "density";
    grid.values = values.data();
    for (int i = 0; i < 3; i++) {
        grid.first[i] = -(count / 2);
        grid.size[i] = count;
        grid.index_to_world[5 * i] = voxel_m;
    }
    grid.index_to_world[15] = 1;
    vdb_write(path, &grid, 1);
}
