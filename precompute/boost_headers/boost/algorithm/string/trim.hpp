#pragma once
#include <string>
namespace boost {
inline void trim(std::string &text)
{
    const char *const space = " \t\r\n\v\f";
    text.erase(text.find_last_not_of(space) + 1);
    text.erase(0, text.find_first_not_of(space));
}
}
