#ifndef AIRLIGHT_FUZZ_CONTAINER_H
#define AIRLIGHT_FUZZ_CONTAINER_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
