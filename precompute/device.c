#define _POSIX_C_SOURCE 200809L
#include "device.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/container.h"
#include "opencl_texts.h"

static al_status fail_cl(al_error *error, const char *call, cl_int code)
{
    al_status status =
        code == CL_OUT_OF_HOST_MEMORY || code == CL_MEM_OBJECT_ALLOCATION_FAILURE ? AL_IO : AL_NO_DEVICE;
    return al_fail(error, status,
                   "OpenCL: %s answered error %d; choose another device with --device (see --list-devices)%s",
                   call, (int)code, status == AL_IO ? " or a lower --memory-limit" : "");
}

/* Calls `visit` for every device; stops when it answers true. */
static al_status visit_devices(bool (*visit)(cl_platform_id, cl_device_id, unsigned, void *), void *user,
                               al_error *error)
{
    cl_platform_id platforms[16];
    cl_uint platform_count = 0;
    unsigned number = 0;
    if (clGetPlatformIDs(16, platforms, &platform_count) != CL_SUCCESS) platform_count = 0;
    if (platform_count > 16) platform_count = 16;
    for (cl_uint p = 0; p < platform_count; p++) {
        cl_device_id devices[AL_DEVICE_LIMIT];
        cl_uint count = 0;
        if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, AL_DEVICE_LIMIT, devices, &count) != CL_SUCCESS)
            continue;
        for (cl_uint d = 0; d < count && d < AL_DEVICE_LIMIT; d++)
            if (visit(platforms[p], devices[d], number++, user)) return AL_OK;
    }
    if (number == 0)
        return al_fail(
            error, AL_NO_DEVICE,
            "OpenCL: no device found; install a driver, such as Debian's pocl-opencl-icd for the CPU");
    return AL_OK;
}

static void name_device(cl_platform_id platform, cl_device_id device, char name[AL_DEVICE_NAME_SIZE])
{
    char platform_name[96] = "", device_name[128] = "";
    clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof platform_name - 1, platform_name, NULL);
    clGetDeviceInfo(device, CL_DEVICE_NAME, sizeof device_name - 1, device_name, NULL);
    snprintf(name, AL_DEVICE_NAME_SIZE, "%s: %s", platform_name, device_name);
}

static bool add_name(cl_platform_id platform, cl_device_id device, unsigned number, void *user)
{
    al_device_names *names = user;
    if (number >= AL_DEVICE_LIMIT) return true;
    name_device(platform, device, names->names[number]);
    names->count = number + 1;
    return false;
}

al_status al_device_list(al_device_names *names, al_error *error)
{
    names->count = 0;
    return visit_devices(add_name, names, error);
}

typedef struct choice {
    unsigned number;
    cl_platform_id platform;
    cl_device_id device;
    bool found;
} choice;

static bool choose(cl_platform_id platform, cl_device_id device, unsigned number, void *user)
{
    choice *wanted = user;
    if (number != wanted->number) return false;
    wanted->platform = platform;
    wanted->device = device;
    return wanted->found = true;
}

al_status al_device_open(unsigned number, unsigned threads, const char *log_folder, bool verbose,
                         al_device **device, al_error *error)
{
    *device = NULL;
    if (threads > 0) { /* PoCL reads it when its platform is first asked for */
        char text[16];
        snprintf(text, sizeof text, "%u", threads);
        setenv("POCL_MAX_PTHREAD_COUNT", text, 1);
    }
    choice wanted = {.number = number};
    al_status status = visit_devices(choose, &wanted, error);
    if (status != AL_OK) return status;
    if (!wanted.found)
        return al_fail(error, AL_NO_DEVICE,
                       "OpenCL: there is no device %u; --list-devices names what there is", number);

    al_device *opened = calloc(1, sizeof *opened);
    if (!opened) return al_fail(error, AL_IO, "out of memory");
    opened->verbose = verbose;
    opened->id = wanted.device;
    snprintf(opened->log_folder, sizeof opened->log_folder, "%s", log_folder ? log_folder : ".");
    name_device(wanted.platform, wanted.device, opened->name);
    cl_int code;
    opened->context = clCreateContext(NULL, 1, &opened->id, NULL, NULL, &code);
    if (code == CL_SUCCESS) opened->queue = clCreateCommandQueue(opened->context, opened->id, 0, &code);
    if (code != CL_SUCCESS) {
        al_device_close(opened);
        return fail_cl(error, "creating a context and queue", code);
    }
    *device = opened;
    return AL_OK;
}

void al_device_close(al_device *device)
{
    if (!device) return;
    if (device->queue) clReleaseCommandQueue(device->queue);
    if (device->context) clReleaseContext(device->context);
    free(device);
}

static const char *find_text(const char *name, size_t length)
{
    for (unsigned i = 0; i < opencl_texts_count; i++)
        if (strlen(opencl_texts_names[i]) == length && !memcmp(opencl_texts_names[i], name, length))
            return opencl_texts_texts[i];
    return NULL;
}

/* The text of opencl/NAME with its one level of #include "..." put in, line numbers kept. */
static char *expand(const char *name)
{
    const char *text = find_text(name, strlen(name));
    size_t capacity = 256, used = 0;
    for (unsigned i = 0; i < opencl_texts_count; i++) capacity += strlen(opencl_texts_texts[i]) + 128;
    char *out = text ? malloc(capacity) : NULL;
    if (!out) return NULL;
    out[0] = 0;
    for (int line = 1; *text; line++) {
        size_t length = strcspn(text, "\n");
        static const char include[] = "#include \"";
        if (!strncmp(text, include, sizeof include - 1)) {
            const char *start = text + sizeof include - 1;
            size_t name_length = strcspn(start, "\"");
            const char *included = find_text(start, name_length);
            used += (size_t)snprintf(out + used, capacity - used, "#line 1 \"%.*s\"\n%s\n#line %d \"%s\"\n",
                                     (int)name_length, start, included ? included : "#error missing",
                                     line + 1, name);
        } else {
            used += (size_t)snprintf(out + used, capacity - used, "%.*s\n", (int)length, text);
        }
        text += length + (text[length] == '\n');
    }
    return out;
}

static al_status fail_build(al_device *device, cl_program program, const char *file, al_error *error)
{
    size_t size = 0;
    char path[1200], *log = NULL;
    clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, 0, NULL, &size);
    if (size > 0) log = calloc(size + 1, 1);
    if (log) clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, size, log, NULL);
    snprintf(path, sizeof path, "%s/%s.log", device->log_folder, file);
    al_write_file(path, log ? log : "", log ? strlen(log) : 0, NULL);
    if (device->verbose && log) fprintf(stderr, "%s\n", log);
    free(log);
    return al_fail(error, AL_NO_DEVICE, "opencl/%s: does not build on %s; the compiler's words are in %s",
                   file, device->name, path);
}

al_status al_device_kernel(al_device *device, const char *step, cl_kernel *kernel, al_error *error)
{
    char file[64];
    cl_int code;
    *kernel = NULL;
    snprintf(file, sizeof file, "%s.cl", step);
    char *text = expand(file);
    if (!text) return al_fail(error, AL_IO, "out of memory");
    const char *texts[1] = {text};
    cl_program program = clCreateProgramWithSource(device->context, 1, texts, NULL, &code);
    free(text);
    if (code != CL_SUCCESS) return fail_cl(error, "clCreateProgramWithSource", code);
    code = clBuildProgram(program, 1, &device->id, "-cl-std=CL1.2", NULL, NULL);
    if (code != CL_SUCCESS) {
        al_status status = fail_build(device, program, file, error);
        clReleaseProgram(program);
        return status;
    }
    *kernel = clCreateKernel(program, step, &code);
    clReleaseProgram(program);
    return code == CL_SUCCESS ? AL_OK : fail_cl(error, "clCreateKernel", code);
}

al_status al_device_buffer(al_device *device, size_t size, const void *data, cl_mem *buffer, al_error *error)
{
    cl_int code;
    *buffer = clCreateBuffer(device->context, CL_MEM_READ_WRITE, size ? size : 4, NULL, &code);
    if (code != CL_SUCCESS) return fail_cl(error, "clCreateBuffer", code);
    cl_uint zero = 0;
    code = data ? clEnqueueWriteBuffer(device->queue, *buffer, CL_TRUE, 0, size, data, 0, NULL, NULL)
                : clEnqueueFillBuffer(device->queue, *buffer, &zero, sizeof zero, 0, size ? size : 4, 0, NULL,
                                      NULL);
    if (code == CL_SUCCESS) return AL_OK;
    al_device_release(buffer);
    return fail_cl(error, "filling a buffer", code);
}

al_status al_device_write(al_device *device, cl_mem buffer, const void *data, size_t size, al_error *error)
{
    cl_int code = size ? clEnqueueWriteBuffer(device->queue, buffer, CL_TRUE, 0, size, data, 0, NULL, NULL)
                       : CL_SUCCESS;
    return code == CL_SUCCESS ? AL_OK : fail_cl(error, "clEnqueueWriteBuffer", code);
}

al_status al_device_read(al_device *device, cl_mem buffer, void *data, size_t size, al_error *error)
{
    cl_int code =
        size ? clEnqueueReadBuffer(device->queue, buffer, CL_TRUE, 0, size, data, 0, NULL, NULL) : CL_SUCCESS;
    return code == CL_SUCCESS ? AL_OK : fail_cl(error, "clEnqueueReadBuffer", code);
}

void al_device_release(cl_mem *buffer)
{
    if (*buffer) clReleaseMemObject(*buffer);
    *buffer = NULL;
}

al_status al_device_run(al_device *device, cl_kernel kernel, const size_t size[3],
                        const al_argument *arguments, unsigned argument_count, al_error *error)
{
    for (unsigned i = 0; i < argument_count; i++) {
        cl_int code = clSetKernelArg(kernel, i, arguments[i].size, arguments[i].value);
        if (code != CL_SUCCESS) return fail_cl(error, "clSetKernelArg", code);
    }
    if (size[0] == 0 || size[1] == 0 || size[2] == 0) return AL_OK;
    cl_int code = clEnqueueNDRangeKernel(device->queue, kernel, 3, NULL, size, NULL, 0, NULL, NULL);
    return code == CL_SUCCESS ? AL_OK : fail_cl(error, "clEnqueueNDRangeKernel", code);
}

al_status al_device_finish(al_device *device, al_error *error)
{
    cl_int code = clFinish(device->queue);
    return code == CL_SUCCESS ? AL_OK : fail_cl(error, "clFinish", code);
}
