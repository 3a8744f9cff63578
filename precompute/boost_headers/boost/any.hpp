#pragma once
/* Named by OpenVDB as the value type of a map that the bridge never touches: everything is declared and nothing
 * defined, so that using it cannot link. */
namespace boost {
class any {
public:
    any();
    template <typename T> any(const T &value);
    any(const any &other);
    ~any();
    template <typename T> any &operator=(const T &value);

private:
    void *content;
};
template <typename T> T any_cast(const any &value);
}
