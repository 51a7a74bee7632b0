#include "host/xray/gl/gl_program.hpp"
#include <array>

namespace crn
{
namespace
{

constexpr int log_bytes = 512;

unsigned compile(const GlFunctions &gl, unsigned kind, const char *text)
{
    const unsigned shader = gl.CreateShader(kind);
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    int is_compiled = 0;
    gl.GetShaderiv(shader, gl::compile_status, &is_compiled);
    if (is_compiled) return shader;
    std::array<char, log_bytes> log{};
    gl.GetShaderInfoLog(shader, log_bytes - 1, nullptr, log.data());
    gl.DeleteShader(shader);
    throw GlError("OpenGL: the driver refuses a shader: " + std::string(log.data()));
}

} // namespace

unsigned build_program(const GlFunctions &gl, const char *vertex_text, const char *fragment_text)
{
    const unsigned vertex = compile(gl, gl::vertex_shader, vertex_text);
    unsigned fragment = 0;
    try {
        fragment = compile(gl, gl::fragment_shader, fragment_text);
    } catch (const GlError &) {
        gl.DeleteShader(vertex);
        throw;
    }
    const unsigned program = gl.CreateProgram();
    gl.AttachShader(program, vertex);
    gl.AttachShader(program, fragment);
    gl.LinkProgram(program);
    gl.DeleteShader(vertex);
    gl.DeleteShader(fragment);
    int is_linked = 0;
    gl.GetProgramiv(program, gl::link_status, &is_linked);
    if (is_linked) return program;
    std::array<char, log_bytes> log{};
    gl.GetProgramInfoLog(program, log_bytes - 1, nullptr, log.data());
    gl.DeleteProgram(program);
    throw GlError("OpenGL: the driver refuses a program: " + std::string(log.data()));
}

} // namespace crn
