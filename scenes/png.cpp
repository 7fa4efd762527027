#include "scenes/png.h"

#include <algorithm>
#include <string_view>

namespace sheen::scenes {
namespace {

constexpr size_t kLargestStoredBlock = 65535;

uint32_t crc32(const uint8_t* data, size_t size) {
    uint32_t crc = ~0u;
    for (size_t i = 0; i < size; ++i) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xEDB88320u : 0u);
        }
    }
    return ~crc;
}

uint32_t adler32(const std::vector<uint8_t>& data) {
    uint32_t a = 1;
    uint32_t b = 0;
    for (const uint8_t byte : data) {
        a = (a + byte) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

void writeBigEndian32(std::vector<uint8_t>& out, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        out.push_back(static_cast<uint8_t>(value >> shift));
    }
}

void writeChunk(std::vector<uint8_t>& out, std::string_view type,
                const std::vector<uint8_t>& data) {
    writeBigEndian32(out, static_cast<uint32_t>(data.size()));
    const size_t start = out.size();
    out.insert(out.end(), type.begin(), type.end());
    out.insert(out.end(), data.begin(), data.end());
    writeBigEndian32(out, crc32(out.data() + start, out.size() - start));
}

// A zlib stream of stored blocks. [RFC 1950, RFC 1951 section 3.2.4]
std::vector<uint8_t> storedZlib(const std::vector<uint8_t>& data) {
    std::vector<uint8_t> out = {0x78, 0x01};
    for (size_t start = 0; start < data.size(); start += kLargestStoredBlock) {
        const size_t size = std::min(kLargestStoredBlock, data.size() - start);
        const bool last = start + size == data.size();
        const auto low = static_cast<uint8_t>(size & 255u);
        const auto high = static_cast<uint8_t>(size >> 8);
        out.insert(out.end(), {static_cast<uint8_t>(last ? 1 : 0), low, high,
                               static_cast<uint8_t>(~low), static_cast<uint8_t>(~high)});
        const auto begin = data.begin() + static_cast<std::ptrdiff_t>(start);
        out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(size));
    }
    writeBigEndian32(out, adler32(data));
    return out;
}

}  // namespace

std::vector<uint8_t> encodePng(const Picture& picture) {
    std::vector<uint8_t> header;
    writeBigEndian32(header, static_cast<uint32_t>(picture.width));
    writeBigEndian32(header, static_cast<uint32_t>(picture.height));
    header.insert(header.end(), {8, 2, 0, 0, 0});  // 8 bits, RGB, no interlacing
    std::vector<uint8_t> rows;
    for (int y = 0; y < picture.height; ++y) {
        rows.push_back(0);  // no filter
        for (int x = 0; x < picture.width; ++x) {
            const auto& pixel = picture.pixels[static_cast<size_t>(y * picture.width + x)];
            rows.insert(rows.end(), pixel.begin(), pixel.end());
        }
    }
    std::vector<uint8_t> out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    writeChunk(out, "IHDR", header);
    writeChunk(out, "IDAT", storedZlib(rows));
    writeChunk(out, "IEND", {});
    return out;
}

}  // namespace sheen::scenes
