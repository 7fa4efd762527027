#include "image/hdr.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <new>
#include <sstream>

#include "core/error.h"
#include "core/memory.h"

namespace sheen {
namespace {

constexpr int kMaxHdrSide = 16384;
constexpr int kChannels = 4;  // red, green, blue, their exponent
// Lines of at least this many texels may be run lengths, a channel after the other.
constexpr int kShortestRunLine = 8;

std::string readWhole(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
        throwInput("{}: no such file", path);
    }
    if (!std::filesystem::is_regular_file(status)) {
        throwInput("{}: is not a regular file", path);
    }
    const auto size = static_cast<uint64_t>(std::filesystem::file_size(path, error));
    checkMemory({.bytes = size}, path, "use a smaller image");
    std::ifstream in(path, std::ios::binary);
    std::string bytes(size, '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    if (!in || error) {
        throwInput("{}: cannot be read", path);
    }
    return bytes;
}

// A file's bytes from the front on; what is asked for beyond its end is an error.
class PixelReader {
  public:
    PixelReader(const std::string& path, const std::string& bytes) : path_(path), bytes_(bytes) {}

    std::string line() {
        const size_t end = bytes_.find('\n', at_);
        if (end == std::string::npos) {
            fail("its header does not end");
        }
        std::string text = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        if (!text.empty() && text.back() == '\r') {
            text.pop_back();
        }
        return text;
    }
    uint8_t byte() {
        if (at_ >= bytes_.size()) {
            fail("it ends too early: was it cut short?");
        }
        return static_cast<uint8_t>(bytes_[at_++]);
    }
    // Whether the next bytes begin a line of run lengths, of `width` texels.
    bool startsRuns(int width) const {
        if (width < kShortestRunLine || bytes_.size() - at_ < kChannels) {
            return false;
        }
        const auto at = [&](size_t i) { return static_cast<uint8_t>(bytes_[at_ + i]); };
        return at(0) == 2 && at(1) == 2 && (at(2) << 8 | at(3)) == width;
    }
    size_t left() const { return bytes_.size() - at_; }
    [[noreturn]] void fail(const std::string& why) const {
        throwInput("{}: damaged Radiance file: {}; copy or export it again", path_, why);
    }

  private:
    const std::string& path_;
    const std::string& bytes_;
    size_t at_ = 0;
};

struct Header {
    int width = 0;
    int height = 0;
    float scale = 1.0f;  ///< of the texels, undoing exposures that the file says were applied
};

Header readHeader(const std::string& path, PixelReader& reader) {
    if (reader.line().rfind("#?", 0) != 0) {
        throwInput("{}: not a Radiance file", path);
    }
    Header header;
    for (std::string line = reader.line(); !line.empty(); line = reader.line()) {
        if (line.rfind("FORMAT=", 0) == 0 && line != "FORMAT=32-bit_rle_rgbe") {
            throwInput("{}: {}: must be 32-bit_rle_rgbe; convert it", path, oneLine(line));
        }
        float exposure = 0.0f;
        if (std::sscanf(line.c_str(), "EXPOSURE=%f", &exposure) == 1) {
            if (!(exposure > 0.0f) || !std::isfinite(exposure)) {
                reader.fail("its exposure is no positive number");
            }
            header.scale /= exposure;
        }
    }
    const std::string size = reader.line();
    std::istringstream text(size);
    std::string y, x;
    text >> y >> header.height >> x >> header.width;
    const auto valid = [](int side) { return side >= 1 && side <= kMaxHdrSide; };
    if (!text || y != "-Y" || x != "+X" || !valid(header.height) || !valid(header.width)) {
        throwInput("{}: size '{}': must be -Y HEIGHT +X WIDTH, each 1..{}; convert it", path,
                   oneLine(size), kMaxHdrSide);
    }
    return header;
}

// One line as run lengths; `line` [texel][channel].
void readRuns(PixelReader& reader, int width, std::vector<uint8_t>& line) {
    for (int i = 0; i < kChannels; ++i) {
        reader.byte();  // startsRuns() has seen them
    }
    for (int channel = 0; channel < kChannels; ++channel) {
        for (int x = 0; x < width;) {
            constexpr int kRun = 128;  // more: so many beyond it are equal
            int count = reader.byte();
            const bool run = count > kRun;
            count -= run ? kRun : 0;
            if (count == 0 || count > width - x) {
                reader.fail("a run does not fit its line");
            }
            uint8_t value = run ? reader.byte() : uint8_t{0};
            for (const int end = x + count; x < end; ++x) {
                value = run ? value : reader.byte();
                line[static_cast<size_t>(x * kChannels + channel)] = value;
            }
        }
    }
}

// One line texel by texel; 1 1 1 N repeats the texel before it N times, and where another follows,
// that one N * 256 times.
void readTexels(PixelReader& reader, int width, std::vector<uint8_t>& line) {
    int shift = 0;
    for (int x = 0; x < width;) {
        uint8_t* const texel = &line[static_cast<size_t>(x * kChannels)];
        for (int c = 0; c < kChannels; ++c) {
            texel[c] = reader.byte();
        }
        if (texel[0] != 1 || texel[1] != 1 || texel[2] != 1) {
            ++x;
            shift = 0;
            continue;
        }
        const int64_t count = shift < 24 ? int64_t{texel[3]} << shift : 0;
        if (x == 0 || count == 0 || count > width - x) {
            reader.fail("a run does not fit its line");
        }
        for (const int end = x + static_cast<int>(count); x < end; ++x) {
            std::copy_n(&line[static_cast<size_t>((x - 1) * kChannels)], kChannels,
                        &line[static_cast<size_t>(x * kChannels)]);
        }
        shift += 8;
    }
}

}  // namespace

Image<vec3> readHdr(const std::string& path) {
    const std::string bytes = readWhole(path);
    PixelReader reader(path, bytes);
    const Header header = readHeader(path, reader);
    // A damaged header may promise an image for which there is no memory. A run of 127 takes two
    // bytes, an old one four for 255 * 256 texels.
    constexpr uint64_t kMostPerByte = 1 << 14;
    const auto texels = static_cast<uint64_t>(header.width) * static_cast<uint64_t>(header.height);
    if (texels > kMostPerByte * reader.left()) {
        reader.fail(fmt::format("its {} bytes cannot hold {}x{} texels", bytes.size(), header.width,
                                header.height));
    }
    checkMemory({.bytes = texels * sizeof(vec3)},
                fmt::format("{}, {}x{} texels", path, header.width, header.height),
                "use a smaller image");
    Image<vec3> image(header.width, header.height);
    std::vector<uint8_t> line(static_cast<size_t>(header.width) * kChannels);
    for (int y = 0; y < header.height; ++y) {
        if (reader.startsRuns(header.width)) {
            readRuns(reader, header.width, line);
        } else {
            readTexels(reader, header.width, line);
        }
        for (int x = 0; x < header.width; ++x) {
            constexpr int kExponentOfOne = 128 + 8;
            const uint8_t* const t = &line[static_cast<size_t>(x * kChannels)];
            const float unit = t[3] == 0 ? 0.0f : std::ldexp(header.scale, t[3] - kExponentOfOne);
            image.at(x, y) = unit * vec3(t[0], t[1], t[2]);
        }
    }
    return image;
}

}  // namespace sheen
