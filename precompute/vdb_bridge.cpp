#include "vdb_bridge.h"

#include <openvdb/Types.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

namespace
{

struct entry {
    std::string name; /* "density", or "density[1]" where several share a name */
    std::string base; /* without [i] */
    openvdb::GridBase::ConstPtr facts;
};

std::vector<entry> list_grids(openvdb::io::File &file)
{
    std::vector<entry> entries;
    for (auto at = file.beginName(); at != file.endName(); ++at) {
        openvdb::GridBase::ConstPtr facts = file.readGridMetadata(*at);
        entries.push_back({*at, facts->getName(), facts});
    }
    return entries;
}

std::string describe(const std::vector<entry> &entries)
{
    std::string text;
    for (const entry &one : entries) {
        text += (text.empty() ? "\"" : ", \"") + one.name + "\" (" + one.facts->valueType();
        if (one.facts->getGridClass() != openvdb::GRID_UNKNOWN)
            text += ", " + openvdb::GridBase::gridClassToString(one.facts->getGridClass());
        text += ")";
        if (text.size() > 600) return text + ", ...";
    }
    return text.empty() ? "no grids" : text;
}

bool is_density(const entry &one)
{
    return one.facts->isType<openvdb::FloatGrid>() && one.facts->getGridClass() != openvdb::GRID_LEVEL_SET;
}

/* The one entry that `name` means, or NULL after an error. */
const entry *choose(const char *path, const std::string &name, const std::vector<entry> &entries,
                    al_error *error)
{
    const entry *found = nullptr;
    size_t same = 0;
    for (size_t i = 0; i < entries.size(); i++) {
        const entry &one = entries[i];
        size_t earlier = 0;
        for (size_t k = 0; k < i; k++) earlier += entries[k].base == one.base;
        const bool meant = name.empty() ? is_density(one) : one.base == name;
        if (one.name == name || one.base + "[" + std::to_string(earlier) + "]" == name) found = &one;
        if (meant) {
            if (!found) found = &one;
            same++;
        }
    }
    if (same > 1) {
        al_fail(error, AL_BAD_INPUT, "%s: several grids are %s; choose one by name, or name[i]: %s", path,
                name.empty() ? "float densities" : ("named \"" + name + "\"").c_str(),
                describe(entries).c_str());
        return nullptr;
    }
    if (!found && name.empty() && entries.size() == 1)
        found = &entries[0]; /* is_density says below what is wrong */
    if (!found)
        al_fail(error, AL_BAD_INPUT, "%s: no %s; the file has %s", path,
                name.empty() ? "float density" : ("grid is named \"" + name + "\"").c_str(),
                describe(entries).c_str());
    return found;
}

al_status refuse_kind(const char *path, const entry &one, const std::vector<entry> &entries, al_error *error)
{
    const bool level_set = one.facts->getGridClass() == openvdb::GRID_LEVEL_SET;
    return al_fail(error, AL_BAD_INPUT, "%s: grid \"%s\" is %s; a float fog volume is right, the file has %s",
                   path, one.name.c_str(),
                   level_set ? "a level set" : ("of type " + one.facts->valueType()).c_str(),
                   describe(entries).c_str());
}

void affine(const openvdb::math::Transform &transform, const openvdb::Coord &first, double out[16])
{
    const openvdb::Vec3d origin = transform.indexToWorld(first.asVec3d());
    for (int column = 0; column < 3; column++) {
        openvdb::Vec3d ahead = first.asVec3d();
        ahead[column] += 1;
        const openvdb::Vec3d axis = transform.indexToWorld(ahead) - origin;
        for (int row = 0; row < 3; row++) out[column * 4 + row] = axis[row];
        out[column * 4 + 3] = 0;
    }
    for (int row = 0; row < 3; row++) out[12 + row] = origin[row];
    out[15] = 1;
}

al_status copy_values(const char *path, const openvdb::FloatGrid &source, const openvdb::CoordBBox &box,
                      al_vdb_grid &out, al_error *error)
{
    const openvdb::FloatGrid::ConstAccessor voxels = source.getConstAccessor();
    size_t at = 0;
    for (int z = box.min().z(); z <= box.max().z(); z++)
        for (int y = box.min().y(); y <= box.max().y(); y++)
            for (int x = box.min().x(); x <= box.max().x(); x++, at++) {
                const float value = voxels.getValue(openvdb::Coord(x, y, z));
                if (!(value >= 0 && std::isfinite(value))) {
                    const openvdb::Vec3d where = source.indexToWorld(openvdb::Vec3d(x, y, z));
                    return al_fail(error, AL_BAD_INPUT,
                                   "%s: grid \"%s\" is %g in voxel (%d, %d, %d), at (%.6g, %.6g, "
                                   "%.6g); a finite density of 0 or more is right",
                                   path, source.getName().c_str(), value, x, y, z, where.x(), where.y(),
                                   where.z());
                }
                out.values[at] = value;
                if (value > out.largest) out.largest = value;
            }
    return AL_OK;
}

al_status read_dense(const char *path, const openvdb::FloatGrid &source, uint64_t size_limit,
                     al_vdb_grid &out, al_error *error)
{
    const std::string name = source.getName();
    if (!source.transform().isLinear())
        return al_fail(error, AL_BAD_INPUT,
                       "%s: grid \"%s\" has a perspective transform; an affine one is right", path,
                       name.c_str());
    const openvdb::CoordBBox box = source.evalActiveVoxelBoundingBox();
    if (box.empty())
        return al_fail(error, AL_BAD_INPUT, "%s: grid \"%s\" has no active voxels", path, name.c_str());
    double bytes = sizeof(float);
    for (int i = 0; i < 3; i++) {
        const double edge = double(box.max()[i]) - box.min()[i] + 1;
        out.size[i] = static_cast<uint32_t>(edge);
        bytes *= edge;
    }
    if (bytes > static_cast<double>(size_limit))
        return al_fail(error, AL_BAD_INPUT,
                       "%s: grid \"%s\" spans %u x %u x %u voxels, %.0f MiB as floats; at most "
                       "%llu MiB are right: resample or crop it",
                       path, name.c_str(), out.size[0], out.size[1], out.size[2], bytes / 1048576,
                       static_cast<unsigned long long>(size_limit >> 20));
    affine(source.transform(), box.min(), out.index_to_world);
    out.values = static_cast<float *>(std::malloc(static_cast<size_t>(bytes)));
    if (!out.values)
        return al_fail(error, AL_IO, "%s: out of memory for %.0f MiB of grid \"%s\"", path, bytes / 1048576,
                       name.c_str());
    return copy_values(path, source, box, out, error);
}

al_status read_grid(const char *path, const char *grid_name, uint64_t size_limit, al_vdb_grid &out,
                    al_error *error)
{
    openvdb::initialize();
    openvdb::io::File file(path);
    file.open(false);
    const std::vector<entry> entries = list_grids(file);
    const entry *one = choose(path, grid_name, entries, error);
    if (!one) return AL_BAD_INPUT;
    if (!is_density(*one)) return refuse_kind(path, *one, entries, error);
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(one->name));
    if (!grid) return al_fail(error, AL_BAD_INPUT, "%s: grid \"%s\" cannot be read", path, one->name.c_str());
    return read_dense(path, *grid, size_limit, out, error);
}

} // namespace

extern "C" al_status al_vdb_read(const char *path, const char *grid_name, uint64_t size_limit,
                                 al_vdb_grid *grid, al_error *error)
{
    al_status status;
    *grid = al_vdb_grid{};
    try {
        status = read_grid(path, grid_name, size_limit, *grid, error);
    } catch (const std::bad_alloc &) {
        status = al_fail(error, AL_IO, "%s: out of memory while reading the grid", path);
    } catch (const std::exception &problem) {
        status = al_fail(error, AL_BAD_INPUT, "%s: cannot be read as OpenVDB: %s", path, problem.what());
    }
    if (status) {
        std::free(grid->values);
        *grid = al_vdb_grid{};
    }
    return status;
}
