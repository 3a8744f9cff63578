/* The OpenCL device that the steps run on. */
#ifndef AIRLIGHT_DEVICE_H
#define AIRLIGHT_DEVICE_H

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <stdbool.h>
#include <stddef.h>

#include "airlight/status.h"

enum { AL_DEVICE_LIMIT = 64, AL_DEVICE_NAME_SIZE = 256 };

typedef struct al_device {
    cl_device_id id;
    cl_context context;
    cl_command_queue queue;
    char name[AL_DEVICE_NAME_SIZE]; /* "platform: device" */
    char log_folder[1024];          /* where build logs of failing kernels go */
    bool verbose;                   /* whole build logs on standard error too */
} al_device;

typedef struct al_device_names {
    char names[AL_DEVICE_LIMIT][AL_DEVICE_NAME_SIZE];
    unsigned count;
} al_device_names;

/* Every device of every platform, in the order of their numbers. AL_NO_DEVICE when there is none. */
al_status al_device_list(al_device_names *names, al_error *error);

/* Opens device `number` of that list. threads > 0 limits a CPU device. */
al_status al_device_open(unsigned number, unsigned threads, const char *log_folder, bool verbose,
                         al_device **device, al_error *error);
void al_device_close(al_device *device);

/* Compiles opencl/`step`.cl (embedded) and answers its kernel of the same name. On a build error the log is
 * written to a file named in the message. */
al_status al_device_kernel(al_device *device, const char *step, cl_kernel *kernel, al_error *error);

/* A buffer, zeroed when `data` is NULL, else a copy of it. */
al_status al_device_buffer(al_device *device, size_t size, const void *data, cl_mem *buffer, al_error *error);
al_status al_device_write(al_device *device, cl_mem buffer, const void *data, size_t size, al_error *error);
al_status al_device_read(al_device *device, cl_mem buffer, void *data, size_t size, al_error *error);
void al_device_release(cl_mem *buffer); /* NULL is allowed */

typedef struct al_argument { /* of a kernel: size and address of the value */
    size_t size;
    const void *value;
} al_argument;
#define AL_ARGUMENT(name) ((al_argument){sizeof(name), &(name)})

/* Sets the arguments and enqueues over `size`. */
al_status al_device_run(al_device *device, cl_kernel kernel, const size_t size[3],
                        const al_argument *arguments, unsigned argument_count, al_error *error);
al_status al_device_finish(al_device *device, al_error *error);

#endif
