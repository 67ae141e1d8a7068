// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/png_file.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <csetjmp>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace afterglow {

/// libpng's last words. It may not return from reporting an error, and an exception cannot pass
/// through it.
struct PngErrorText {
    char text[128] = "";
};

namespace {

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
    auto *words = static_cast<PngErrorText *>(png_get_error_ptr(png));
    std::strncpy(words->text, message, sizeof words->text - 1);
    png_longjmp(png, 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Calls libpng by way of `work`, which must own nothing: an error jumps out of it past any
/// destructor.
template <class Work>
bool succeeds(png_structp png, const Work &work) {
    if (setjmp(png_jmpbuf(png)) != 0)
        return false;
    work();
    return true;
}

void read_bytes(png_structp png, png_bytep to, std::size_t count) {
    auto *rest = static_cast<std::string_view *>(png_get_io_ptr(png));
    if (rest->size() < count)
        png_error(png, "the file is cut short");
    std::memcpy(to, rest->data(), count);
    rest->remove_prefix(count);
}

/// What libpng needs for itself: rows, tables, zlib's window.
constexpr std::size_t usual_bytes = std::size_t{4} << 20;

/// libpng makes room for as much as a chunk claims to have before it finds that the file ends. No
/// room would not do: it goes on behind the chunk's name.
png_voidp allocate(png_structp png, png_alloc_size_t bytes) {
    if (bytes > *static_cast<const std::size_t *>(png_get_mem_ptr(png)))
        png_error(png, "a chunk is larger than the file");
    return std::malloc(bytes);
}

void release(png_structp /*png*/, png_voidp memory) {
    std::free(memory);
}

Error out_of_memory() {
    return {"there is no memory for libpng", ENOMEM};
}

} // namespace

struct PngDecoder::Library {
    explicit Library(std::string_view bytes)
        : rest(bytes), most_bytes(std::max(bytes.size(), usual_bytes)) {
        png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &words, on_error, on_warning,
                                       &most_bytes, allocate, release);
        if (png != nullptr)
            info = png_create_info_struct(png);
    }
    ~Library() { png_destroy_read_struct(&png, &info, nullptr); }
    Library(const Library &) = delete;
    Library &operator=(const Library &) = delete;

    Error error() const { return {fmt::format("is not a sound PNG file: {}", words.text), EINVAL}; }

    std::string_view rest;
    std::size_t most_bytes; ///< at once
    PngErrorText words;
    png_structp png = nullptr;
    png_infop info = nullptr;
};

PngDecoder::PngDecoder(std::string_view bytes) : library_(std::make_unique<Library>(bytes)) {}

PngDecoder::~PngDecoder() = default;

Status PngDecoder::read_header(int max_side) {
    const png_structp png = library_->png;
    const png_infop info = library_->info;
    if (info == nullptr)
        return out_of_memory();
    const bool done = succeeds(png, [&] {
        png_set_read_fn(png, &library_->rest, read_bytes);
        png_set_user_limits(png, static_cast<png_uint_32>(max_side),
                            static_cast<png_uint_32>(max_side));
        png_read_info(png, info);
    });
    if (!done)
        return library_->error();
    width_ = static_cast<int>(png_get_image_width(png, info));
    height_ = static_cast<int>(png_get_image_height(png, info));
    return ok();
}

bool PngDecoder::is_grey() const {
    return (png_get_color_type(library_->png, library_->info) & PNG_COLOR_MASK_COLOR) == 0;
}

int PngDecoder::bits() const {
    return png_get_bit_depth(library_->png, library_->info);
}

Status PngDecoder::read_rows8(std::vector<std::uint8_t *> rows) {
    const std::size_t channels = is_grey() ? 1 : 3;
    const png_structp png = library_->png;
    const bool done = succeeds(png, [&] {
        png_set_scale_16(png);
        png_set_palette_to_rgb(png);
        png_set_expand_gray_1_2_4_to_8(png);
        png_set_strip_alpha(png);
    });
    if (!done)
        return library_->error();
    return read_rows(std::move(rows), static_cast<std::size_t>(width_) * channels);
}

Status PngDecoder::read_rows16(std::vector<std::uint8_t *> rows) {
    assert(bits() == 16 && is_grey());
    const png_structp png = library_->png;
    const bool done = succeeds(png, [&] {
        png_set_strip_alpha(png);
        if constexpr (std::endian::native == std::endian::little)
            png_set_swap(png);
    });
    if (!done)
        return library_->error();
    return read_rows(std::move(rows), static_cast<std::size_t>(width_) * 2);
}

Status PngDecoder::read_rows(std::vector<std::uint8_t *> rows, std::size_t row_bytes) {
    assert(rows.size() == static_cast<std::size_t>(height_));
    const png_structp png = library_->png;
    const png_infop info = library_->info;
    const bool done = succeeds(png, [&] {
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
        if (png_get_rowbytes(png, info) != row_bytes)
            png_error(png, "its pixels have a format that is not understood");
        png_read_image(png, rows.data());
        png_read_end(png, nullptr);
    });
    if (!done)
        return library_->error();
    return ok();
}

Status encode_png(std::FILE *file, const PngLayout &layout,
                  std::span<const std::uint8_t *const> rows) {
    assert(rows.size() == static_cast<std::size_t>(layout.height));
    PngErrorText words;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &words, on_error, on_warning);
    if (png == nullptr)
        return out_of_memory();
    png_infop info = png_create_info_struct(png);
    const bool done =
        info != nullptr && succeeds(png, [&] {
            // Pictures of sensor noise: more effort makes them hardly smaller, and much slower.
            png_set_compression_level(png, 3);
            png_init_io(png, file);
            png_set_IHDR(png, info, static_cast<png_uint_32>(layout.width),
                         static_cast<png_uint_32>(layout.height), layout.bits,
                         layout.is_grey ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
                         PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
            png_write_info(png, info);
            if (layout.bits == 16 && std::endian::native == std::endian::little)
                png_set_swap(png);
            for (const std::uint8_t *row : rows)
                png_write_row(png, row);
            png_write_end(png, info);
        });
    png_destroy_write_struct(&png, &info);
    if (!done)
        return Error{fmt::format("could not be written: {}", words.text), EIO};
    return ok();
}

} // namespace afterglow
