#pragma once
#include <type_traits>
namespace boost { namespace numeric {
template <typename T, typename S, bool = std::is_arithmetic<T>::value && std::is_arithmetic<S>::value>
struct conversion_traits { /* a class absorbs a number: vector times scalar is a vector */
    using supertype = typename std::conditional<std::is_class<T>::value, T, S>::type;
};
template <typename T, typename S>
struct conversion_traits<T, S, true> {
    using supertype = typename std::common_type<T, S>::type;
};
} }
