// Typed errors and checks. An Error is something the user can mend: it becomes one line on stderr
// and an exit code in cli/. A failed CHECK is a bug of ours and stays on in release builds.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <string>

namespace sheen {

/// The program's exit codes.
enum class ExitCode { kDone = 0, kBug = 1, kUsage = 2, kInput = 3, kEnvironment = 4 };

/// Text from a file or a library, fit for a message: control characters become spaces, those at the
/// end are left out, and long text is cut.
std::string oneLine(std::string text);

/// An error with the exit code it leads to. The message is one line: file, where, what, how to
/// mend; control characters in it, which come from names in files, become spaces.
class Error : public std::runtime_error {
  public:
    Error(ExitCode code, const std::string& message);
    ExitCode code() const { return code_; }

  private:
    ExitCode code_;
};

template <class... Args>
[[noreturn]] void throwUsage(fmt::format_string<Args...> format, Args&&... args) {
    throw Error(ExitCode::kUsage, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
[[noreturn]] void throwInput(fmt::format_string<Args...> format, Args&&... args) {
    throw Error(ExitCode::kInput, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
[[noreturn]] void throwEnvironment(fmt::format_string<Args...> format, Args&&... args) {
    throw Error(ExitCode::kEnvironment, fmt::format(format, std::forward<Args>(args)...));
}

/// Throws std::logic_error; the CHECK macros below call it.
[[noreturn]] void checkFailed(const char* file, int line, const std::string& what);

/// Prints text on stderr; where that cannot be written there is no one left to tell.
void say(const std::string& text);

/// Prints "sheen: warning: ..." on stderr.
void warn(const std::string& message);

}  // namespace sheen

#define SHEEN_CHECK(condition)                                    \
    do {                                                          \
        if (!(condition)) {                                       \
            ::sheen::checkFailed(__FILE__, __LINE__, #condition); \
        }                                                         \
    } while (false)

#define SHEEN_CHECK_EQ(a, b)                                                                 \
    do {                                                                                     \
        const auto& check_a = (a);                                                           \
        const auto& check_b = (b);                                                           \
        if (!(check_a == check_b)) {                                                         \
            ::sheen::checkFailed(__FILE__, __LINE__,                                         \
                                 fmt::format(#a " == " #b " ({} vs {})", check_a, check_b)); \
        }                                                                                    \
    } while (false)
