#pragma once
#include <cstdint>
namespace boost { namespace uuids {
struct uuid {
    std::uint8_t data[16];
};
} }
