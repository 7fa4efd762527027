// Values as bytes for another process of the same build, and back.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/error.h"

namespace sheen {

class ByteWriter {
  public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    void put(const std::string& text) { putAll(text.data(), text.size()); }
    template <class T>
    void put(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        putAll(values.data(), values.size());
    }
    const std::string& bytes() const { return bytes_; }

  private:
    template <class T>
    void putAll(const T* values, uint64_t count) {
        put(count);
        bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
    }

    std::string bytes_;
};

/// Reads what a ByteWriter wrote, in the same order; a failed check where there is less. The bytes
/// must outlive it.
class ByteReader {
  public:
    explicit ByteReader(std::string_view bytes) : left_(bytes) {}

    template <class T>
    T get() {
        T value{};
        if constexpr (std::is_trivially_copyable_v<T>) {
            copy(&value, 1);
        } else {
            const auto count = get<uint64_t>();
            SHEEN_CHECK(count <= left_.size());
            value.resize(count);
            copy(value.data(), count);
        }
        return value;
    }
    bool atEnd() const { return left_.empty(); }

  private:
    template <class T>
    void copy(T* values, size_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        const size_t size = count * sizeof(T);
        SHEEN_CHECK(size <= left_.size());
        if (size > 0) {
            std::memcpy(static_cast<void*>(values), left_.data(), size);
        }
        left_.remove_prefix(size);
    }

    std::string_view left_;
};

}  // namespace sheen
