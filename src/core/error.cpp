#include "core/error.h"

#include <cstdio>

namespace sheen {

void checkFailed(const char* file, int line, const std::string& what) {
    throw std::logic_error(fmt::format("{}:{}: check failed: {}", file, line, what));
}

void warn(const std::string& message) { fmt::print(stderr, "sheen: warning: {}\n", message); }

}  // namespace sheen
