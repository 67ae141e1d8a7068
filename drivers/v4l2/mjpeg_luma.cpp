// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/mjpeg_luma.hpp"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <memory>

// After <cstdio>: these headers expect FILE and size_t to be there.
#include <jpeglib.h>

#include <jerror.h>

namespace afterglow::v4l2 {
namespace {

/// libjpeg-turbo's own interface: TurboJPEG does not tell a harmless warning from a bad one.
class JpegDecoder {
public:
    JpegDecoder() {
        jpeg_.err = jpeg_std_error(&errors_);
        jpeg_create_decompress(&jpeg_);
        jpeg_.client_data = this;
        errors_.error_exit = [](j_common_ptr jpeg) { std::longjmp(self(jpeg)->failed_, 1); };
        errors_.emit_message = [](j_common_ptr jpeg, int level) {
            if (level < 0 && jpeg->err->msg_code != JWRN_EXTRANEOUS_DATA)
                self(jpeg)->damaged_ = true;
        };
    }
    ~JpegDecoder() { jpeg_destroy_decompress(&jpeg_); }
    JpegDecoder(const JpegDecoder &) = delete;
    JpegDecoder &operator=(const JpegDecoder &) = delete;

    std::string_view read(std::span<const std::uint8_t> bytes, ImageView<std::uint8_t> luma) {
        damaged_ = false;
        // No object with a destructor lives in this frame, so that jumping out of it is sound.
        if (setjmp(failed_) != 0) { // NOLINT(cert-err52-cpp): libjpeg knows no other way
            jpeg_abort_decompress(&jpeg_);
            return "it is no complete JPEG image";
        }
        jpeg_mem_src(&jpeg_, bytes.data(), static_cast<unsigned long>(bytes.size()));
        jpeg_read_header(&jpeg_, TRUE);
        if (jpeg_.image_width != static_cast<JDIMENSION>(luma.width()) ||
            jpeg_.image_height != static_cast<JDIMENSION>(luma.height())) {
            jpeg_abort_decompress(&jpeg_);
            return "it is of another size";
        }
        jpeg_.out_color_space = JCS_GRAYSCALE;
        jpeg_start_decompress(&jpeg_);
        while (jpeg_.output_scanline < jpeg_.output_height) {
            JSAMPROW row = luma.row(static_cast<int>(jpeg_.output_scanline));
            jpeg_read_scanlines(&jpeg_, &row, 1);
        }
        jpeg_finish_decompress(&jpeg_);
        return damaged_ ? "its JPEG data is damaged" : "";
    }

private:
    static JpegDecoder *self(j_common_ptr jpeg) {
        return static_cast<JpegDecoder *>(jpeg->client_data);
    }

    jpeg_decompress_struct jpeg_ = {};
    jpeg_error_mgr errors_ = {};
    std::jmp_buf failed_ = {};
    bool damaged_ = false;
};

} // namespace

LumaReader make_mjpeg_reader() {
    // Shared because a std::function must be copyable; there is one owner.
    auto decoder = std::make_shared<JpegDecoder>();
    return [decoder](std::span<const std::uint8_t> bytes, ImageView<std::uint8_t> luma) {
        return decoder->read(bytes, luma);
    };
}

} // namespace afterglow::v4l2
