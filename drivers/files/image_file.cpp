// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"

#include "core/base/printable.hpp"
#include "core/base/read_file.hpp"
#include "core/base/write_file.hpp"
#include "drivers/files/png_file.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace afterglow {
namespace {

template <class T>
std::vector<std::uint8_t *> rows_of(ImageView<T> image) {
    std::vector<std::uint8_t *> rows;
    rows.reserve(static_cast<std::size_t>(image.height()));
    for (int v = 0; v < image.height(); ++v)
        rows.push_back(reinterpret_cast<std::uint8_t *>(image.row(v)));
    return rows;
}

/// Where the pixels of a file go: into memory of the size that the file turns out to have, or into
/// memory that is there already and sets the size that the file must have.
template <class T>
class Destination {
public:
    explicit Destination(Image<T> &image) : grows_(&image) {}
    explicit Destination(ImageView<T> view) : view_(view) {}

    Status set_size(int width, int height) {
        if (width < 1 || height < 1 || width > max_image_side || height > max_image_side)
            return Error{fmt::format("is {} x {} pixels, and sides of 1 to {} are read", width,
                                     height, max_image_side),
                         EFBIG};
        if (grows_ != nullptr) {
            *grows_ = Image<T>(width, height);
            view_ = grows_->view();
        } else if (width != view_.width() || height != view_.height()) {
            return Error{fmt::format("is {} x {} pixels instead of {} x {}", width, height,
                                     view_.width(), view_.height()),
                         EINVAL};
        }
        return ok();
    }
    ImageView<T> view() const { return view_; }

private:
    Image<T> *grows_ = nullptr;
    ImageView<T> view_;
};

Status decode_png(std::string_view bytes, Destination<std::uint8_t> &luma) {
    PngDecoder png(bytes);
    if (Status read = png.read_header(max_image_side); !read)
        return read;
    if (Status sized = luma.set_size(png.width(), png.height()); !sized)
        return sized;
    if (png.is_grey())
        return png.read_rows8(rows_of(luma.view()));

    Image<Rgb> color(png.width(), png.height());
    if (Status read = png.read_rows8(rows_of(color.view())); !read)
        return read;
    for (int v = 0; v < color.height(); ++v) {
        for (int u = 0; u < color.width(); ++u)
            luma.view()(u, v) = luma_of(color(u, v));
    }
    return ok();
}

Status decode_png16(std::string_view bytes, Destination<std::uint16_t> &pixels) {
    PngDecoder png(bytes);
    if (Status read = png.read_header(max_image_side); !read)
        return read;
    if (!png.is_grey() || png.bits() != 16)
        return Error{fmt::format("has {}-bit {} pixels, and 16-bit grey is needed", png.bits(),
                                 png.is_grey() ? "grey" : "colour"),
                     EINVAL};
    if (Status sized = pixels.set_size(png.width(), png.height()); !sized)
        return sized;
    return png.read_rows16(rows_of(pixels.view()));
}

Status decode_jpeg(std::string_view bytes, Destination<std::uint8_t> &luma) {
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitDecompress(), tjDestroy);
    const auto problem = [&] {
        return Error{fmt::format("is not a sound JPEG file: {}", tjGetErrorStr2(jpeg.get())),
                     EINVAL};
    };
    const auto *data = reinterpret_cast<const unsigned char *>(bytes.data());
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    if (!jpeg || tjDecompressHeader3(jpeg.get(), data, bytes.size(), &width, &height, &subsampling,
                                     &colorspace) != 0)
        return problem();
    if (Status sized = luma.set_size(width, height); !sized)
        return sized;
    // A file cut short is only worth a warning to the library, which comes back as a failure too.
    if (tjDecompress2(jpeg.get(), data, bytes.size(), luma.view().data(), width,
                      luma.view().stride(), height, TJPF_GRAY, TJFLAG_LIMITSCANS) != 0)
        return problem();
    return ok();
}

Status decode_luma(std::string_view bytes, Destination<std::uint8_t> &luma) {
    if (bytes.starts_with("\x89PNG\r\n\x1a\n"))
        return decode_png(bytes, luma);
    if (bytes.starts_with("\xff\xd8"))
        return decode_jpeg(bytes, luma);
    return Error{"is neither a PNG nor a JPEG file", EINVAL};
}

/// Reads a file and decodes it; the error of either names the file.
template <class T>
Status read_with(Status (*decode)(std::string_view, Destination<T> &), const std::string &path,
                 Destination<T> destination) {
    const Result<std::string> bytes = read_file(path);
    if (!bytes)
        return bytes.error();
    Status decoded = decode(*bytes, destination);
    if (!decoded)
        return Error{fmt::format("{}: {}", printable(path), decoded.error().message),
                     decoded.error().code};
    return decoded;
}

template <class T>
Result<Image<T>> read_whole(Status (*decode)(std::string_view, Destination<T> &),
                            const std::string &path) {
    Image<T> image;
    if (Status read = read_with(decode, path, Destination<T>(image)); !read)
        return read.error();
    return image;
}

template <class T>
Status write_rows(const std::string &path, ImageView<const T> image, const PngLayout &layout) {
    Result<OutputFile> output = OutputFile::open(path);
    if (!output)
        return output.error();
    // The library writes to a stream, which closes its own descriptor.
    std::FILE *file = fdopen(fcntl(output->fd(), F_DUPFD_CLOEXEC, 0), "wb");
    if (file == nullptr)
        return output->error();
    std::vector<const std::uint8_t *> rows;
    for (int v = 0; v < image.height(); ++v)
        rows.push_back(reinterpret_cast<const std::uint8_t *>(image.row(v)));
    const Status encoded = encode_png(file, layout, rows);
    const bool refused = std::ferror(file) != 0; // by the file system, and errno says why
    const bool closed = std::fclose(file) == 0;
    if (encoded && closed)
        return output->finish();
    if (encoded || refused)
        return output->error();
    return Error{fmt::format("{}: {}", printable(path), encoded.error().message), EINVAL};
}

} // namespace

Result<Luma> read_luma(const std::string &path) {
    return read_whole(decode_luma, path);
}

Status read_luma(const std::string &path, ImageView<std::uint8_t> luma) {
    return read_with(decode_luma, path, Destination(luma));
}

Result<Image<std::uint16_t>> read_grey16(const std::string &path) {
    return read_whole(decode_png16, path);
}

Status read_grey16(const std::string &path, ImageView<std::uint16_t> pixels) {
    return read_with(decode_png16, path, Destination(pixels));
}

Status write_png(const std::string &path, LumaView luma) {
    return write_rows(path, luma, {luma.width(), luma.height(), 8, true});
}

Status write_png(const std::string &path, DepthView depth) {
    return write_rows(path, depth, {depth.width(), depth.height(), 16, true});
}

Status write_png(const std::string &path, ImageView<const Rgb> picture) {
    static_assert(sizeof(Rgb) == 3);
    return write_rows(path, picture, {picture.width(), picture.height(), 8, false});
}

} // namespace afterglow
