#include "image/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTestFile.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <new>

#include "core/error.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "image/atomic_file.h"

namespace sheen {
namespace {

constexpr float kHalfMax = 65504.0f;
constexpr int kMaxSide = 16384;
constexpr std::array<const char*, 3> kRgb = {"R", "G", "B"};
constexpr std::array<const char*, 3> kXyz = {"X", "Y", "Z"};
const char* const kPrimitiveChannel = "primitive.id";

// OpenEXR's own file stream loses errors that show only when the file is closed.
class AtomicStream : public Imf::OStream {
  public:
    explicit AtomicStream(AtomicFile& file) : OStream(file.path().c_str()), file_(file) {}
    void write(const char data[], int size) override {
        file_.write(data, static_cast<size_t>(size));
    }
    uint64_t tellp() override { return file_.position(); }
    void seekp(uint64_t position) override { file_.seek(position); }

  private:
    AtomicFile& file_;
};

// The channels of a file to be written and the pixels they come from.
class Channels {
  public:
    Channels(int width, int height, bool exact) : width_(width), height_(height), exact_(exact) {}

    // A layer of three channels; `prefix` is empty for the unnamed layer or ends in a dot.
    void addColor(const std::string& prefix, const std::array<const char*, 3>& names,
                  const Image<vec3>& image, bool as_half) {
        if (image.empty()) {
            return;
        }
        checkSize(image.width, image.height);
        const float* values = &image.pixels[0].x;
        const bool half = as_half && suitsHalf(values, 3 * image.pixels.size());
        for (size_t c = 0; c < 3; ++c) {
            addFloats(prefix + names[c], values + c, 3, half);
        }
    }

    void addScalar(const std::string& name, const Image<float>& image, bool as_half) {
        if (image.empty()) {
            return;
        }
        checkSize(image.width, image.height);
        addFloats(name, image.pixels.data(), 1, as_half);
    }

    void addMatte(const Matte& matte) {
        for (size_t r = 0; r < matte.ranks.size(); ++r) {
            const Image<vec4>& rank = matte.ranks[r];
            checkSize(rank.width, rank.height);
            for (int c = 0; c < 4; ++c) {
                insert(fmt::format("{}{:02}.{}", matte.layer, r, "RGBA"[c]), Imf::FLOAT,
                       &rank.pixels[0][c], sizeof(vec4));
            }
        }
    }

    void addIds(const std::string& name, const Image<uint32_t>& image) {
        checkSize(image.width, image.height);
        insert(name, Imf::UINT, image.pixels.data(), sizeof(uint32_t));
    }

    void write(AtomicFile& file, const Imf::Header& plain) const {
        Imf::Header header = plain;
        header.channels() = list_;
        AtomicStream stream(file);
        Imf::OutputFile output(stream, header, Imf::globalThreadCount());
        output.setFrameBuffer(pixels_);
        output.writePixels(height_);
    }

  private:
    void checkSize(int width, int height) const {
        SHEEN_CHECK_EQ(width, width_);
        SHEEN_CHECK_EQ(height, height_);
    }

    // Below 2^-14 halves lose digits, and they end at 65504. Light that is dim all over, as in
    // scenes whose unit is small, is kept in floats: what is not black is on average dimmer than
    // 2^-8. So is light that is brighter anywhere.
    static bool suitsHalf(const float* values, size_t count) {
        double sum = 0.0;
        size_t lit = 0;
        for (size_t i = 0; i < count; ++i) {
            const float value = std::abs(values[i]);
            if (value > kHalfMax && std::isfinite(value)) {
                return false;
            }
            sum += value;
            lit += value != 0.0f ? 1 : 0;
        }
        return !(sum < 0x1p-8 * static_cast<double>(lit));
    }

    void addFloats(const std::string& name, const float* values, size_t stride, bool as_half) {
        if (!as_half || exact_) {
            insert(name, Imf::FLOAT, values, stride * sizeof(float));
            return;
        }
        const size_t count = static_cast<size_t>(width_) * static_cast<size_t>(height_);
        std::vector<half>& halves = halves_.emplace_back(count);
        for (size_t i = 0; i < count; ++i) {
            halves[i] = half(values[i * stride]);
        }
        insert(name, Imf::HALF, halves.data(), sizeof(half));
    }

    void insert(const std::string& name, Imf::PixelType type, const void* data, size_t stride) {
        list_.insert(name, Imf::Channel(type));
        // OpenEXR's slices serve reading and writing alike, hence the cast; it only reads here.
        char* base = static_cast<char*>(const_cast<void*>(data));
        pixels_.insert(name, Imf::Slice(type, base, stride, stride * static_cast<size_t>(width_)));
    }

    int width_;
    int height_;
    bool exact_;
    Imf::ChannelList list_;
    Imf::FrameBuffer pixels_;
    std::deque<std::vector<half>> halves_;  // a deque: slices point into its elements
};

// Layers whose names the header comment lists (OpenEXR sorts channels by name).
void addLayers(Channels& channels, const Frame& frame, ExrLayers wanted) {
    channels.addIds(kPrimitiveChannel, frame.primitive);
    for (const FrameLayer& layer : layersOf(frame)) {
        if (wanted != ExrLayers::kAll && !layer.basic) {
            continue;
        }
        const std::string prefix = std::string(layer.in_files) + ".";
        switch (layer.kind) {
            case FrameLayer::Kind::kColor:
                channels.addColor(prefix, kRgb, *layer.triples, !layer.exact);
                break;
            case FrameLayer::Kind::kVector:
                channels.addColor(prefix, kXyz, *layer.triples, !layer.exact);
                break;
            case FrameLayer::Kind::kNumber:
                channels.addScalar(prefix + "Y", *layer.numbers, !layer.exact);
                break;
            case FrameLayer::Kind::kDepth:
                channels.addScalar(layer.in_files, *layer.numbers, !layer.exact);
                break;
        }
    }
}

void insertMatte(const Matte& matte, Imf::Header& header) {
    constexpr int kDigits = 7;  // by which attributes that belong together are known
    const auto bits = std::bit_cast<uint32_t>(matteIdentifier(matte.layer));
    const std::string key = "cryptomatte/" + fmt::format("{:08x}", bits).substr(0, kDigits) + "/";
    header.insert(key + "name", Imf::StringAttribute(matte.layer));
    header.insert(key + "hash", Imf::StringAttribute("MurmurHash3_32"));
    header.insert(key + "conversion", Imf::StringAttribute("uint32_to_float32"));
    header.insert(key + "manifest", Imf::StringAttribute(matte.manifest));
}

// Files of some writers name a triple but miss a channel: better said than read as a scalar.
bool hasTriple(const Imf::ChannelList& list, const std::string& path, const std::string& prefix,
               const std::array<const char*, 3>& names) {
    int found = 0;
    for (const char* name : names) {
        found += list.findChannel(prefix + name) != nullptr ? 1 : 0;
    }
    if (found == 2) {
        throwInput("{}: layer '{}' lacks one of the channels {}, {}, {}", path,
                   prefix.empty() ? "beauty" : prefix.substr(0, prefix.size() - 1), names[0],
                   names[1], names[2]);
    }
    return found == 3;
}

// Points OpenEXR at the images its channels go to. Slices address pixels in the file's own
// coordinates, hence the shift by the data window's corner.
class Reader {
  public:
    Reader(LoadedExr& exr, Imf::InputFile& file) : exr_(exr), file_(file) {
        const Imath::Box2i window = file.header().dataWindow();
        origin_x_ = window.min.x;
        origin_y_ = window.min.y;
    }

    void read() {
        const Imf::ChannelList& list = file_.header().channels();
        for (auto channel = list.begin(); channel != list.end(); ++channel) {
            if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
                throwInput("{}: channel '{}' is subsampled, which Sheen does not read", exr_.path,
                           channel.name());
            }
            addChannel(list, channel.name());
        }
        file_.setFrameBuffer(pixels_);
        const Imath::Box2i window = file_.header().dataWindow();
        file_.readPixels(window.min.y, window.max.y);
    }

  private:
    void addChannel(const Imf::ChannelList& list, const std::string& name) {
        if (name == kPrimitiveChannel && list.findChannel(name)->type == Imf::UINT) {
            exr_.primitive = Image<uint32_t>(exr_.width, exr_.height);
            insert(name, Imf::UINT, exr_.primitive.pixels.data(), sizeof(uint32_t));
            return;
        }
        const size_t dot = name.rfind('.');
        const std::string prefix = dot == std::string::npos ? "" : name.substr(0, dot + 1);
        const std::string channel = name.substr(prefix.size());
        for (const auto& names : {kRgb, kXyz}) {
            const auto it = std::find(names.begin(), names.end(), channel);
            if (it == names.end() || !hasTriple(list, exr_.path, prefix, names)) {
                continue;
            }
            const std::string layer = prefix.empty() ? "beauty" : name.substr(0, dot);
            Image<vec3>& image = exr_.colors[layer];
            if (image.empty()) {
                image = Image<vec3>(exr_.width, exr_.height);
            }
            float* values = &image.pixels[0].x + (it - names.begin());
            insert(name, Imf::FLOAT, values, sizeof(vec3));
            return;
        }
        Image<float>& image = exr_.scalars[name] = Image<float>(exr_.width, exr_.height);
        insert(name, Imf::FLOAT, image.pixels.data(), sizeof(float));
    }

    void insert(const std::string& name, Imf::PixelType type, void* data, size_t stride) {
        const ptrdiff_t row = static_cast<ptrdiff_t>(stride) * exr_.width;
        // In integers: the window's corner may lie so far off that a pointer would overflow.
        const auto address = reinterpret_cast<uintptr_t>(data) -
                             stride * static_cast<uintptr_t>(ptrdiff_t{origin_x_}) -
                             static_cast<uintptr_t>(row * ptrdiff_t{origin_y_});
        pixels_.insert(name, Imf::Slice(type, reinterpret_cast<char*>(address), stride,
                                        static_cast<size_t>(row)));
    }

    LoadedExr& exr_;
    Imf::InputFile& file_;
    Imf::FrameBuffer pixels_;
    int origin_x_ = 0;
    int origin_y_ = 0;
};

// A damaged header may promise an image for which there is no memory. No compression packs pixels
// tighter than this: zlib 1032 to 1, of which PXR24 makes 1376; DWA run lengths of 127 on top.
void checkPlausible(const Imf::Header& header, const std::string& path, int64_t width,
                    int64_t height) {
    int64_t pixel_size = 0;
    int64_t channels = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        pixel_size += c.channel().type == Imf::HALF ? 2 : 4;
        ++channels;
    }
    const bool is_dwa = header.compression() == Imf::DWAA_COMPRESSION ||
                        header.compression() == Imf::DWAB_COMPRESSION;
    const int64_t most_per_byte = is_dwa ? 1 << 17 : 1400;
    const auto file_size = static_cast<int64_t>(std::filesystem::file_size(path));
    if (width * height > file_size * most_per_byte / std::max<int64_t>(pixel_size, 1)) {
        throwInput(
            "{}: damaged EXR file: its {} bytes cannot hold the {}x{} pixels that its header "
            "promises; copy or render it again",
            path, file_size, width, height);
    }
    constexpr int64_t kBytesPerChannel = sizeof(float);
    checkMemory({.bytes = static_cast<uint64_t>(width * height * channels * kBytesPerChannel)},
                fmt::format("{}, {}x{} pixels of {} channels", path, width, height, channels),
                "use a smaller image");
}

void checkIsExr(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
        throwInput("{}: no such file", path);
    }
    if (std::filesystem::is_directory(status)) {
        throwInput("{}: is a directory, not an EXR file", path);
    }
    if (!Imf::isOpenExrFile(path.c_str())) {
        throwInput("{}: not an EXR file, or not readable", path);
    }
}

void addColors(Channels& channels, std::span<const ExrColors> layers) {
    for (const ExrColors& layer : layers) {
        channels.addColor(layer.name + ".", kRgb, *layer.colors, false);
    }
}

Imf::Header headerOf(int width, int height, const ExrNotes& notes) {
    Imf::Header header(width, height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [name, text] : notes.texts) {
        header.insert(name, Imf::StringAttribute(text));
    }
    for (const auto& [name, number] : notes.numbers) {
        header.insert(name, Imf::FloatAttribute(number));
    }
    return header;
}

void writeChannels(const std::string& path, const Channels& channels, const Imf::Header& header) {
    AtomicFile file(path);
    Imf::setGlobalThreadCount(threadCount());
    try {
        channels.write(file, header);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        throwEnvironment("{}: cannot write: {}", path, oneLine(error.what()));
    }
    file.commit();
}

}  // namespace

void writeExr(const std::string& path, const Frame& frame, ExrLayers layers, const ExrNotes& notes,
              std::span<const Matte> mattes, std::span<const ExrColors> more) {
    SHEEN_CHECK(!frame.primitive.empty());
    const bool exact = !frame.indirect_variance.empty() || !frame.indirect_diffuse_variance.empty();
    const Image<vec3> beauty_image = beauty(frame);
    const Image<float> alpha_image = alpha(frame);
    Channels channels(frame.width(), frame.height(), exact);
    channels.addColor("", kRgb, beauty_image, true);
    channels.addScalar("A", alpha_image, true);
    addLayers(channels, frame, layers);
    for (const Matte& matte : mattes) {
        channels.addMatte(matte);
    }
    addColors(channels, more);
    Imf::Header header = headerOf(frame.width(), frame.height(), notes);
    for (const Matte& matte : mattes) {
        insertMatte(matte, header);
    }
    writeChannels(path, channels, header);
}

void writeExrLayers(const std::string& path, std::span<const ExrColors> colors,
                    const std::map<std::string, Image<float>>& numbers, const ExrNotes& notes) {
    SHEEN_CHECK(!colors.empty());
    const ivec2 size(colors.front().colors->width, colors.front().colors->height);
    Channels channels(size.x, size.y, true);
    addColors(channels, colors);
    for (const auto& [name, image] : numbers) {
        channels.addScalar(name, image, false);
    }
    writeChannels(path, channels, headerOf(size.x, size.y, notes));
}

LoadedExr readExr(const std::string& path) {
    checkIsExr(path);
    LoadedExr exr;
    exr.path = path;
    Imf::setGlobalThreadCount(threadCount());
    try {
        Imf::InputFile file(path.c_str());
        const Imath::Box2i window = file.header().dataWindow();
        const int64_t width = int64_t{window.max.x} - window.min.x + 1;
        const int64_t height = int64_t{window.max.y} - window.min.y + 1;
        if (width > kMaxSide || height > kMaxSide) {
            throwInput("{}: {}x{} pixels are more than {} a side", path, width, height, kMaxSide);
        }
        if (!file.isComplete()) {
            throwInput("{}: incomplete EXR file: was it cut short?", path);
        }
        checkPlausible(file.header(), path, width, height);
        exr.width = static_cast<int>(width);
        exr.height = static_cast<int>(height);
        Reader(exr, file).read();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throwEnvironment("{}: {}x{} pixels do not fit in memory", path, exr.width, exr.height);
    } catch (const std::exception& error) {
        throwInput("{}: damaged EXR file: {}; copy or render it again", path,
                   oneLine(error.what()));
    }
    return exr;
}

const Image<vec3>& colorLayer(const LoadedExr& exr, const std::string& name) {
    const auto found = exr.colors.find(name);
    if (found != exr.colors.end()) {
        return found->second;
    }
    std::string known;
    for (const auto& [layer, image] : exr.colors) {
        known += (known.empty() ? "" : ", ") + layer;
    }
    throwInput("{}: no layer '{}'; the file has: {}", exr.path, name,
               known.empty() ? "no colour layers" : oneLine(known));
}

}  // namespace sheen
