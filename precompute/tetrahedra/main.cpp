/* airlight-tetrahedra: fills a closed surface with tetrahedra, or makes the Delaunay mesh of points.
 *
 * Reads a file or standard input, writes a file or standard output; little-endian, nothing between the parts:
 *   in:   8 bytes "ALTETIN1", u64 point count P, u64 triangle count T (0 for Delaunay),
 *         f64 [P][3] positions, u32 [T][3] corners, counter-clockwise seen from outside
 *   out:  8 bytes "ALTETOU1", u64 point count P', u64 tetrahedron count N,
 *         f64 [P'][3] positions, u32 [N][4] corners of positive volume
 * The first P positions of the output are the input's, bit by bit; more follow where the surface cannot be
 * filled without. Surfaces keep their triangles; cavities (inner surfaces that face inwards) stay empty.
 * A surface that cuts itself, as many scans do a little, cannot be kept: it is filled with columns instead
 * (columns.h), and the output begins with "ALTETCO1".
 *
 * TetGen ends its caller in many ways, so it works in a child process: whatever happens to that becomes one
 * line and an exit code. */
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <map>
#include <new>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#define TETLIBRARY
#include <tetgen.h>

#include "airlight/program.h"
#include "columns.h"

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "arrays are read and written as they lie in memory");

namespace
{

struct header {
    char magic[8];
    uint64_t point_count, cell_count;
};
static_assert(sizeof(header) == 24, "no padding");

constexpr uint64_t count_limit = 100000000;

bool read_surface(FILE *in, surface &out, std::string &problem)
{
    header head;
    if (std::fread(&head, sizeof head, 1, in) != 1 || std::memcmp(head.magic, "ALTETIN1", 8) != 0) {
        problem = "does not begin with \"ALTETIN1\" and two counts";
        return false;
    }
    if (head.point_count > count_limit || head.cell_count > count_limit) {
        problem = "names more than 100000000 points or triangles";
        return false;
    }
    out.points.resize(head.point_count * 3);
    out.corners.resize(head.cell_count * 3);
    if (std::fread(out.points.data(), sizeof(double), out.points.size(), in) != out.points.size() ||
        std::fread(out.corners.data(), sizeof(uint32_t), out.corners.size(), in) != out.corners.size()) {
        problem = "ends too early";
        return false;
    }
    for (size_t i = 0; i < out.points.size(); i++)
        if (!std::isfinite(out.points[i])) {
            problem = "point " + std::to_string(i / 3) + " is not finite";
            return false;
        }
    for (size_t i = 0; i < out.corners.size(); i++)
        if (out.corners[i] >= head.point_count) {
            problem = "triangle " + std::to_string(i / 3) + " names point " + std::to_string(out.corners[i]) +
                      " of " + std::to_string(head.point_count);
            return false;
        }
    return true;
}

void fill_input(const surface &from, tetgenio &in) /* tetgenio frees with delete[] */
{
    in.numberofpoints = static_cast<int>(from.points.size() / 3);
    in.pointlist = new double[from.points.size()];
    std::memcpy(in.pointlist, from.points.data(), from.points.size() * sizeof(double));
    in.numberoffacets = static_cast<int>(from.corners.size() / 3);
    if (!in.numberoffacets) return;
    in.facetlist = new tetgenio::facet[static_cast<size_t>(in.numberoffacets)];
    for (int i = 0; i < in.numberoffacets; i++) {
        tetgenio::facet &facet = in.facetlist[i];
        tetgenio::init(&facet);
        facet.numberofpolygons = 1;
        facet.polygonlist = new tetgenio::polygon[1];
        tetgenio::init(facet.polygonlist);
        facet.polygonlist->numberofvertices = 3;
        facet.polygonlist->vertexlist = new int[3];
        for (int k = 0; k < 3; k++)
            facet.polygonlist->vertexlist[k] = static_cast<int>(from.corners[i * 3 + k]);
    }
}

/* How often the surface winds around a point: the sum of the triangles' solid angles over 4 pi
 * (Van Oosterom and Strackee 1983). */
double winding(const surface &from, const double point[3])
{
    double sum = 0;
    for (size_t t = 0; t < from.corners.size(); t += 3) {
        double v[3][3], length[3], dot[3];
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++) v[k][i] = from.points[from.corners[t + k] * size_t{3} + i] - point[i];
            length[k] = std::sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
        }
        for (int k = 0; k < 3; k++) {
            const double *a = v[k], *b = v[(k + 1) % 3];
            dot[k] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        }
        const double triple = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                              v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                              v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        sum += 2 * std::atan2(triple, length[0] * length[1] * length[2] + dot[0] * length[2] +
                                          dot[1] * length[0] + dot[2] * length[1]);
    }
    return sum / (4 * 3.14159265358979323846);
}

/* Six times the signed volume. */
double volume6(const tetgenio &mesh, const int *corners)
{
    const double *p[4];
    for (int k = 0; k < 4; k++) p[k] = mesh.pointlist + corners[k] * size_t{3};
    double e[3][3];
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) e[k][i] = p[k + 1][i] - p[0][i];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/* TetGen numbers the regions that facets separate (switch A); a region is inside when the surface winds
 * around its largest tetrahedron's centre. */
std::map<int, bool> find_interior(const surface &from, const tetgenio &mesh)
{
    std::map<int, int> largest;
    for (int t = 0; t < mesh.numberoftetrahedra; t++) {
        const int region = static_cast<int>(mesh.tetrahedronattributelist[t]);
        auto known = largest.find(region);
        if (known == largest.end())
            largest[region] = t;
        else if (std::fabs(volume6(mesh, mesh.tetrahedronlist + t * size_t{4})) >
                 std::fabs(volume6(mesh, mesh.tetrahedronlist + known->second * size_t{4})))
            known->second = t;
    }
    std::map<int, bool> inside;
    for (const auto &one : largest) {
        double centre[3] = {0, 0, 0};
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 3; i++)
                centre[i] += mesh.pointlist[mesh.tetrahedronlist[one.second * 4 + k] * size_t{3} + i] / 4;
        inside[one.first] = winding(from, centre) > 0.5;
    }
    return inside;
}

std::vector<uint32_t> collect(const surface &from, const tetgenio &mesh)
{
    std::map<int, bool> inside;
    std::vector<uint32_t> corners;
    if (!from.corners.empty()) inside = find_interior(from, mesh);
    for (int t = 0; t < mesh.numberoftetrahedra; t++) {
        if (!inside.empty() && !inside[static_cast<int>(mesh.tetrahedronattributelist[t])]) continue;
        const int *c = mesh.tetrahedronlist + t * size_t{4};
        const bool turned = volume6(mesh, c) < 0;
        const uint32_t order[4] = {static_cast<uint32_t>(c[0]), static_cast<uint32_t>(c[turned ? 2 : 1]),
                                   static_cast<uint32_t>(c[turned ? 1 : 2]), static_cast<uint32_t>(c[3])};
        corners.insert(corners.end(), order, order + 4);
    }
    return corners;
}

bool write_mesh(FILE *out, const char *magic, const double *points, uint64_t point_count,
                const std::vector<uint32_t> &corners)
{
    header head;
    std::memcpy(head.magic, magic, sizeof head.magic);
    head.point_count = point_count;
    head.cell_count = corners.size() / 4;
    return std::fwrite(&head, sizeof head, 1, out) == 1 &&
           std::fwrite(points, sizeof(double[3]), point_count, out) == point_count &&
           std::fwrite(corners.data(), sizeof(uint32_t), corners.size(), out) == corners.size() &&
           std::fflush(out) == 0;
}

/* What the child ends with. TetGen's own codes: 1 memory, 2 internal, 3 self-intersection, 4 and 5 features
 * too small or too close, 10 input; whoever else ends the child (a sanitizer: 1) means as much as 2. */
enum : int { INTERNAL = 2, FAILED_TO_WRITE = 100, NO_INTERIOR = 101, OUT_OF_MEMORY = 102 };

/* p: fill a surface. Y: keep its triangles. A: number the regions. z: count from 0. Q: no words. */
int work(const surface &from, FILE *out)
{
    char fill[] = "pYAzQ", delaunay[] = "zQ";
    try {
        tetgenio in, mesh;
        fill_input(from, in);
        tetrahedralize(from.corners.empty() ? delaunay : fill, &in, &mesh);
        const std::vector<uint32_t> corners = collect(from, mesh);
        if (corners.empty()) return NO_INTERIOR;
        const uint64_t count = static_cast<uint64_t>(mesh.numberofpoints);
        return write_mesh(out, "ALTETOU1", mesh.pointlist, count, corners) ? 0 : FAILED_TO_WRITE;
    } catch (int code) {
        if (code == 1) return OUT_OF_MEMORY;
        return code > 0 && code < FAILED_TO_WRITE ? code : INTERNAL;
    } catch (const std::bad_alloc &) {
        return OUT_OF_MEMORY;
    }
}

/* Runs `work` in a child whose standard output leads nowhere: TetGen prints there. */
int work_in_child(const surface &from, FILE *out, bool verbose)
{
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        const int quiet = open("/dev/null", O_WRONLY);
        const int kept = dup(fileno(out));
        dup2(verbose ? STDERR_FILENO : quiet, STDOUT_FILENO);
        if (!verbose) dup2(quiet, STDERR_FILENO);
        FILE *result = kept < 0 ? nullptr : fdopen(kept, "wb");
        _exit(result ? work(from, result) : FAILED_TO_WRITE);
    }
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child) return OUT_OF_MEMORY;
    return WIFEXITED(status) ? WEXITSTATUS(status) : INTERNAL;
}

int work_with_columns(const surface &from, FILE *out)
{
    const uint32_t resolution = 256;
    const surface filled = fill_with_columns(from, resolution);
    if (filled.corners.empty()) return NO_INTERIOR;
    return write_mesh(out, "ALTETCO1", filled.points.data(), filled.points.size() / 3, filled.corners)
               ? 0
               : FAILED_TO_WRITE;
}

al_status explain(int code, const char *name, const char *output, al_error *error)
{
    switch (code) {
    case 0:
        return AL_OK;
    case OUT_OF_MEMORY:
        return al_fail(error, AL_IO, "%s: out of memory", name);
    case FAILED_TO_WRITE:
        return al_fail(error, AL_IO, "%s: cannot write the tetrahedra", output);
    case NO_INTERIOR:
        return al_fail(error, AL_BAD_INPUT,
                       "%s: there is nothing inside; a closed surface that faces "
                       "outwards is right",
                       name);
    default:
        return al_fail(error, AL_BAD_INPUT,
                       "%s: TetGen ended with %d; points that do not all lie in one plane "
                       "are right",
                       name, code);
    }
}

al_status run(const char *input, const char *output, bool verbose, al_error *error)
{
    surface from;
    std::string problem;
    const char *name = input ? input : "standard input";
    FILE *in = input ? std::fopen(input, "rb") : stdin;
    if (!in) return al_fail_errno(error, name, "open");
    const bool good = read_surface(in, from, problem);
    if (input) std::fclose(in);
    if (!good) return al_fail(error, AL_BAD_INPUT, "%s: %s", name, problem.c_str());
    if (from.corners.empty() && from.points.size() < 12)
        return al_fail(error, AL_BAD_INPUT, "%s: has %zu points; at least 4 are right", name,
                       from.points.size() / 3);
    FILE *out = output ? std::fopen(output, "wb") : stdout;
    if (!out) return al_fail(error, AL_IO, "%s: cannot write: %s", output, std::strerror(errno));
    int code = work_in_child(from, out, verbose);
    if (code > 0 && code < FAILED_TO_WRITE && !from.corners.empty()) code = work_with_columns(from, out);
    if (output) std::fclose(out);
    const al_status status = explain(code, name, output ? output : "standard output", error);
    struct stat about;
    if (status && output && !stat(output, &about) && S_ISREG(about.st_mode)) std::remove(output);
    return status;
}

} // namespace

int main(int argc, char **argv)
{
    const char *output = nullptr, *input[1] = {nullptr};
    size_t input_count = 0;
    const al_option options[] = {
        {"-o", "OUT", AL_OPTION_STRING, &output, "write here instead of to standard output", 0, 0}};
    al_program program = {};
    program.name = "airlight-tetrahedra";
    program.usage = "[IN] [-o OUT]";
    program.summary =
        "Fills a closed surface with tetrahedra (TetGen); without triangles, makes the Delaunay mesh of "
        "the points. Binary in, binary out: see the source. The bake starts it.";
    program.options = options;
    program.option_count = 1;
    const int code = al_program_parse(&program, argc, argv, input, 0, 1, &input_count);
    if (code >= 0) return code;
    al_error error;
    try {
        const al_status status = run(input_count ? input[0] : nullptr, output, program.verbose, &error);
        return status ? al_program_fail(&program, &error) : 0;
    } catch (const std::bad_alloc &) {
        al_fail(&error, AL_IO, "out of memory while reading the surface");
        return al_program_fail(&program, &error);
    }
}
