#include "core/error.h"

#include <algorithm>
#include <cstdio>

#include "core/listener.h"

namespace sheen {
namespace {

std::string withoutControls(std::string text) {
    const auto is_control = [](char c) {
        return static_cast<unsigned char>(c) < 0x20 || c == '\x7f';
    };
    std::replace_if(text.begin(), text.end(), is_control, ' ');
    return text;
}

}  // namespace

std::string oneLine(std::string text) {
    constexpr size_t kLongest = 240;
    text = withoutControls(std::move(text));
    text.resize(text.find_last_not_of(' ') + 1);
    if (text.size() <= kLongest) {
        return text;
    }
    size_t end = kLongest;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) {
        --end;  // not within a UTF-8 character
    }
    return text.substr(0, end) + "...";
}

Error::Error(ExitCode code, const std::string& message)
    : std::runtime_error(withoutControls(message)), code_(code) {}

void checkFailed(const char* file, int line, const std::string& what) {
    throw std::logic_error(fmt::format("{}:{}: check failed: {}", file, line, what));
}

void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

void warn(const std::string& message) {
    const Listener* listener = currentListener();
    if (listener == nullptr) {
        say(fmt::format("sheen: warning: {}\n", message));
    } else if (listener->warning) {
        listener->warning(oneLine(message));
    }
}

}  // namespace sheen
