// Declares the functions and constants of OpenGL 3.3 core that this project uses (Khronos registry), as a
// table whose functions are loaded by name. The program is linked with no OpenGL library: libOSMesa and libGL
// both export gl* functions, and those of a linked library would replace the other library's.
#pragma once
#include <cstddef>
#include <cstdint>

namespace crn
{

// X(result, name without gl, arguments)
#define CRN_GL_FUNCTIONS(X)                                                                                  \
    X(unsigned, GetError, ())                                                                                \
    X(const unsigned char *, GetString, (unsigned name))                                                     \
    X(void, GetIntegerv, (unsigned name, int *value))                                                        \
    X(void, Enable, (unsigned what))                                                                         \
    X(void, Disable, (unsigned what))                                                                        \
    X(void, Viewport, (int x, int y, int width, int height))                                                 \
    X(void, Scissor, (int x, int y, int width, int height))                                                  \
    X(void, ClearColor, (float red, float green, float blue, float alpha))                                   \
    X(void, Clear, (unsigned mask))                                                                          \
    X(void, BlendEquation, (unsigned mode))                                                                  \
    X(void, BlendFunc, (unsigned source, unsigned destination))                                              \
    X(void, FrontFace, (unsigned mode))                                                                      \
    X(void, PixelStorei, (unsigned name, int value))                                                         \
    X(void, ReadBuffer, (unsigned buffer))                                                                   \
    X(void, ReadPixels, (int x, int y, int width, int height, unsigned format, unsigned type, void *pixels)) \
    X(void, DrawArrays, (unsigned mode, int first, int count))                                               \
    X(void, DrawArraysInstanced, (unsigned mode, int first, int count, int instances))                       \
    X(void, MultiDrawElements,                                                                               \
      (unsigned mode, const int *counts, unsigned type, const void *const *offsets, int draws))              \
    X(void, GenTextures, (int count, unsigned *names))                                                       \
    X(void, DeleteTextures, (int count, const unsigned *names))                                              \
    X(void, BindTexture, (unsigned target, unsigned name))                                                   \
    X(void, TexParameteri, (unsigned target, unsigned name, int value))                                      \
    X(void, TexImage2D,                                                                                      \
      (unsigned target, int level, int internal_format, int width, int height, int border, unsigned format,  \
       unsigned type, const void *pixels))                                                                   \
    X(void, TexImage3D,                                                                                      \
      (unsigned target, int level, int internal_format, int width, int height, int depth, int border,        \
       unsigned format, unsigned type, const void *pixels))                                                  \
    X(void, TexSubImage2D,                                                                                   \
      (unsigned target, int level, int x, int y, int width, int height, unsigned format, unsigned type,      \
       const void *pixels))                                                                                  \
    X(void, GenFramebuffers, (int count, unsigned *names))                                                   \
    X(void, DeleteFramebuffers, (int count, const unsigned *names))                                          \
    X(void, BindFramebuffer, (unsigned target, unsigned name))                                               \
    X(void, FramebufferTexture2D,                                                                            \
      (unsigned target, unsigned attachment, unsigned texture_target, unsigned texture, int level))          \
    X(unsigned, CheckFramebufferStatus, (unsigned target))                                                   \
    X(void, GenBuffers, (int count, unsigned *names))                                                        \
    X(void, DeleteBuffers, (int count, const unsigned *names))                                               \
    X(void, BindBuffer, (unsigned target, unsigned name))                                                    \
    X(void, BufferData, (unsigned target, std::ptrdiff_t bytes, const void *data, unsigned usage))           \
    X(void, BufferSubData, (unsigned target, std::ptrdiff_t offset, std::ptrdiff_t bytes, const void *data)) \
    X(void, GenVertexArrays, (int count, unsigned *names))                                                   \
    X(void, DeleteVertexArrays, (int count, const unsigned *names))                                          \
    X(void, BindVertexArray, (unsigned name))                                                                \
    X(void, EnableVertexAttribArray, (unsigned index))                                                       \
    X(void, VertexAttribPointer,                                                                             \
      (unsigned index, int size, unsigned type, unsigned char normalised, int stride, const void *offset))   \
    X(void, VertexAttribDivisor, (unsigned index, unsigned divisor))                                         \
    X(unsigned, CreateShader, (unsigned kind))                                                               \
    X(void, DeleteShader, (unsigned name))                                                                   \
    X(void, ShaderSource, (unsigned shader, int count, const char *const *texts, const int *lengths))        \
    X(void, CompileShader, (unsigned shader))                                                                \
    X(void, GetShaderiv, (unsigned shader, unsigned name, int *value))                                       \
    X(void, GetShaderInfoLog, (unsigned shader, int capacity, int *length, char *text))                      \
    X(unsigned, CreateProgram, ())                                                                           \
    X(void, DeleteProgram, (unsigned name))                                                                  \
    X(void, AttachShader, (unsigned program, unsigned shader))                                               \
    X(void, LinkProgram, (unsigned program))                                                                 \
    X(void, GetProgramiv, (unsigned program, unsigned name, int *value))                                     \
    X(void, GetProgramInfoLog, (unsigned program, int capacity, int *length, char *text))                    \
    X(void, UseProgram, (unsigned program))                                                                  \
    X(int, GetUniformLocation, (unsigned program, const char *name))                                         \
    X(void, Uniform1f, (int place, float x))                                                                 \
    X(void, Uniform1i, (int place, int x))                                                                   \
    X(void, Uniform3f, (int place, float x, float y, float z))                                               \
    X(void, Uniform4f, (int place, float x, float y, float z, float w))

struct GlFunctions {
#define CRN_GL_MEMBER(result, name, arguments) result(*name) arguments = nullptr;
    CRN_GL_FUNCTIONS(CRN_GL_MEMBER)
#undef CRN_GL_MEMBER
};

namespace gl
{

constexpr unsigned colour_buffer_bit = 0x4000, triangles = 4, triangle_strip = 5;
constexpr unsigned one = 1, func_add = 0x8006, blend = 0x0BE2, cull_face = 0x0B44, depth_test = 0x0B71,
                   scissor_test = 0x0C11, front_clockwise = 0x0900;
constexpr unsigned texture_2d = 0x0DE1, texture_3d = 0x806F, min_filter = 0x2801, mag_filter = 0x2800,
                   wrap_s = 0x2802, wrap_t = 0x2803, nearest = 0x2600, linear = 0x2601,
                   clamp_to_edge = 0x812F;
constexpr unsigned red = 0x1903, rgb = 0x1907, rgba = 0x1908, rgb8 = 0x8051, r8 = 0x8229, r32f = 0x822E,
                   r8i = 0x8231, red_integer = 0x8D94, rgba32f = 0x8814;
constexpr unsigned swizzle_r = 0x8E42, swizzle_g = 0x8E43, swizzle_b = 0x8E44, swizzle_a = 0x8E45;
constexpr unsigned type_byte = 0x1400, type_unsigned_byte = 0x1401, type_unsigned_int = 0x1405,
                   type_float = 0x1406;
constexpr unsigned array_buffer = 0x8892, element_array_buffer = 0x8893, static_draw = 0x88E4,
                   stream_draw = 0x88E0;
constexpr unsigned framebuffer = 0x8D40, colour_attachment0 = 0x8CE0, framebuffer_complete = 0x8CD5,
                   back = 0x0405;
constexpr unsigned vertex_shader = 0x8B31, fragment_shader = 0x8B30, compile_status = 0x8B81,
                   link_status = 0x8B82;
constexpr unsigned unpack_alignment = 0x0CF5, pack_alignment = 0x0D05;
constexpr unsigned vendor = 0x1F00, renderer = 0x1F01, version = 0x1F02, max_texture_size = 0x0D33;
constexpr unsigned no_error = 0, out_of_memory = 0x0505, context_lost = 0x0507;

} // namespace gl
} // namespace crn
