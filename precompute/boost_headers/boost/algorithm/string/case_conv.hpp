#pragma once
#include <cctype>
#include <string>
namespace boost {
inline void to_lower(std::string &text)
{
    for (char &c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}
}
