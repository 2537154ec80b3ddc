#include "tests/import/files.h"
#include "tests/loopback/process.h"
#include "tests/scenes/scene_builder.h"
#include "tests/solution/traced_run.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

/// Whatever is wrong: one sentence that names it, exit status 1 or 2, nothing half-written, and soon.
namespace lumenfarm::testing {
namespace {

using test::glb;
using test::replaced;
using test::square_bin;
using test::square_gltf;

/// "lumenfarm ARGUMENTS" fails with `status` and `says`. "@" in an argument stands for the test's folder.
struct Case {
    std::vector<std::string> arguments;
    int status = 2;
    std::string says;
};

std::string lit_gltf() {
    return replaced(square_gltf, R"("name": "paint", )", R"("name": "paint", "emissiveFactor": [1, 1, 1], )");
}

class BadInput : public ::testing::Test {
protected:
    std::string at_home(const std::string& text) const {
        std::string here = text;
        for (auto at = here.find('@'); at != std::string::npos; at = here.find('@'))
            here.replace(at, 1, folder_.path().string());
        return here;
    }

    void expect_refused(const std::string& name, const Case& bad) {
        std::vector<std::string> command{program(name)};
        std::string shown = name;
        for (const auto& argument : bad.arguments) {
            command.push_back(at_home(argument));
            shown += " " + command.back();
        }
        SCOPED_TRACE(shown);
        Process process(command, {"HOME=" + folder_.path().string()});
        const auto status = process.wait();
        ASSERT_TRUE(status.has_value()) << "it hangs";
        EXPECT_EQ(*status, bad.status) << process.err();
        EXPECT_EQ(sentences(process.err()), 1) << process.err();
        EXPECT_NE(process.err().find(at_home(bad.says)), std::string::npos) << process.err();
        EXPECT_EQ(process.out(), "");
        EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "something is left";
        std::filesystem::remove_all(folder_ / "out");
    }
    void expect_all_refused(const std::vector<Case>& cases) {
        for (const auto& bad : cases) expect_refused("lumenfarm", bad);
    }

    /// A scene with a light, named "@/lit.gltf".
    void write_lit_scene() const {
        folder_.write("mesh.bin", square_bin());
        folder_.write("lit.gltf", lit_gltf());
    }

    Folder folder_;

private:
    static int sentences(const std::string& text) {
        std::istringstream lines(text);
        int count = 0;
        for (std::string line; std::getline(lines, line);) count += !line.starts_with("lumenfarm: warning: ");
        return count;
    }
};

/// A socket that listens on loopback and never answers.
class SilentListener {
public:
    SilentListener() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        auto* generic = reinterpret_cast<sockaddr*>(&address);
        if (::bind(socket_, generic, size) != 0 || ::listen(socket_, 8) != 0) std::abort();
        ::getsockname(socket_, generic, &size);
        port_ = ntohs(address.sin_port);
    }
    ~SilentListener() { ::close(socket_); }
    SilentListener(const SilentListener&) = delete;
    SilentListener& operator=(const SilentListener&) = delete;
    std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

private:
    int socket_;
    std::uint16_t port_ = 0;
};

TEST_F(BadInput, Usage) {
    write_lit_scene();
    folder_.write("typo.toml", "[run]\nparticels = 5\n");
    expect_all_refused({
        {{}, 2, "subcommand"},
        {{"fly"}, 2, "fly"},
        {{"run", "-o", "@/out"}, 2, "SCENE"},
        {{"run", "@/lit.gltf"}, 2, "--output"},
        {{"run", "@/lit.gltf", "-o", "@/out", "--fast"}, 2, "--fast"},
        {{"run", "@/lit.gltf", "-o", "@/out", "extra"}, 2, "extra"},
        {{"run", "@/lit.gltf", "-o"}, 2, "--output"},
        {{"run", "@/lit.gltf", "-o", ""}, 2, "output"},
        {{"run", "@/lit.gltf", "-o", "@/out", "--seed", "1", "--seed", "2"}, 2, "--seed"},
        {{"--config", "@/missing.toml", "run", "@/lit.gltf", "-o", "@/out"}, 2, "@/missing.toml"},
        {{"--config", "@/typo.toml", "run", "@/lit.gltf", "-o", "@/out"}, 2, "particels"},
        {{"trace", "@/lit.gltf"}, 2, "--light"},
        {{"trace", "@/lit.gltf", "--light", "moon", "--particles", "1..2"}, 2, "no light 'moon'; it has 0 '"},
        {{"trace", "@/lit.gltf", "--light", "0", "--particles", "2..1"}, 2, "--particles: '2..1' ends before"},
        {{"trace", "@/lit.gltf", "--light", "0", "--particles", "1-2"}, 2, "--particles: '1-2' is not a range"},
        {{"trace", "@/lit.gltf", "--light", "0", "--particles", "0..4294967296"}, 2, "4294967295"},
        {{"trace", "@/lit.gltf", "--light", "0", "--particles", "1", "--cutoff", "7"}, 2, "cutoff"},
        {{"bench"}, 2, "subcommand"},
        {{"bench", "tracer"}, 2, "--generate"},
        {{"bench", "cuts"}, 2, "--generate"},
        {{"bench", "cuts", "@/lit.gltf", "--subspaces", "0"}, 2, "subspaces is 0"},
        {{"bench", "cuts", "@/lit.gltf", "--subspaces", "1e12"}, 2, "subspaces is 4294967295"},
        {{"bench", "cuts", "@/lit.gltf", "--cuts", "33"}, 2, "cuts is 33"},
        {{"bench", "cuts", "@/lit.gltf", "--subspaces", "1", "--particles", "0"}, 2, "particles is 0"},
        {{"bench", "farm", "@/lit.gltf"}, 2, "--output"},
        {{"bench", "farm", "@/lit.gltf", "-o", "@/out", "--workers", "1,0"}, 2, "workers has 0"},
        {{"bench", "farm", "@/lit.gltf", "-o", "@/out", "--workers", "1,x"}, 2, "'1,x'"},
        {{"bench", "farm", "@/lit.gltf", "-o", "@/out", "--particles", "0"}, 2, "particles has 0"},
        {{"bench", "farm", "@/lit.gltf", "-o", "@/out", "--runs", "0"}, 2, "runs is 0"},
        {{"bench", "farm", "@/lit.gltf", "-o", "@/out", "--sweep", "hits-per-message", "--packing", "maps"}, 2, "maps"},
        {{"bench", "farm", "@/lit.gltf", "-o", "@/out", "--memory-limit", "banana"}, 2, "memory-limit"},
        {{"bench", "farm", "@/missing.gltf", "-o", "@/out"}, 2, "@/missing.gltf"},
        {{"bench", "tracer", "--generate", "5"}, 2, "5"},
        {{"bench", "tracer", "--generate", "1e15"}, 2, "1000000000000000"},
    });
}

TEST_F(BadInput, JobOptions) {
    write_lit_scene();
    const std::vector<std::vector<std::string>> options{{"--particles", "0"},
                                                        {"--particles", "-5"},
                                                        {"--particles", "many"},
                                                        {"--particles", "1e12"},
                                                        {"--particles", "nan"},
                                                        {"--particles", "1.5"},
                                                        {"--seed", "-1"},
                                                        {"--seed", "1e30"},
                                                        {"--texel", "-1"},
                                                        {"--texel", "nan"},
                                                        {"--texel", "1e8"},
                                                        {"--cutoff", "0"},
                                                        {"--cutoff", "2"},
                                                        {"--cutoff", "inf"},
                                                        {"--absorption", "perhaps"},
                                                        {"--packing", "zip"},
                                                        {"--strategy", "space"},
                                                        {"--subspaces", "0"},
                                                        {"--subspaces", "1e9"},
                                                        {"--particles-per-set", "0"},
                                                        {"--particles-per-set", "1e12"},
                                                        {"--hits-per-message", "0"},
                                                        {"--hits-per-message", "1e9"},
                                                        {"--keep-hits", "1e15"},
                                                        {"--priority", "5000"},
                                                        {"--name", "two\nlines"},
                                                        {"--workers", "0"},
                                                        {"--workers", "1e6"},
                                                        {"--threads", "1e6"},
                                                        {"--isa", "sse9"},
                                                        {"--ke-scale", "0"},
                                                        {"--scale", "-1"},
                                                        {"--scale", "inf"}};
    for (const auto& option : options)
        expect_refused(
            "lumenfarm",
            {{"run", "@/lit.gltf", "-o", "@/out", option[0], option[1]}, 2, option[0].substr(option[0].size() - 4)});
}

TEST_F(BadInput, Scenes) {
    write_lit_scene();
    folder_.write("empty.gltf", "");
    folder_.write("empty.obj", "");
    folder_.write("empty.lfscene", "");
    folder_.write("garbage.gltf", "what is this?");
    folder_.write("garbage.lfscene", std::string(1'000, 'x'));
    folder_.write("unlit.gltf", square_gltf);
    folder_.write("bomb.gltf", "{\"asset\":" + std::string(2'000'000, '['));
    const std::string whole = glb(lit_gltf(), square_bin());
    folder_.write("cut.glb", whole.substr(0, whole.size() - 20));
    folder_.write("nobuffer.gltf", replaced(lit_gltf(), "mesh.bin", "gone.bin"));
    folder_.write("notexture.obj", "mtllib notexture.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder_.write("notexture.mtl", "newmtl a\nKd 1 1 1\nKe 1 1 1\nmap_Kd gone.png\n");
    folder_.write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    folder_.write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder_.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder_.write("points.obj", "v 0 0 0\nv 1 0 0\n");
    folder_.write("scene.xyz", "1 2 3\n");
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto with_mesh = [&](const std::string& name, const std::string& mesh) {
        folder_.write(name + ".bin", mesh);
        folder_.write(name + ".gltf", replaced(lit_gltf(), "mesh.bin", name + ".bin"));
    };
    with_mesh("index", square_bin({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 9}));
    with_mesh("nan", square_bin({0, 0, 0, 1, nan, 0, 1, 1, 0, 0, 1, 0}));
    with_mesh("inf", square_bin({0, 0, 0, INFINITY, 0, 0, 1, 1, 0, 0, 1, 0}));
    with_mesh("zero", square_bin(std::vector<float>(12, 1.0f)));
    for (const std::string file : {"missing.gltf",    "empty.gltf", "empty.obj", "empty.lfscene", "garbage.gltf",
                                   "garbage.lfscene", "unlit.gltf", "bomb.gltf", "cut.glb",       "nobuffer.gltf",
                                   "notexture.obj",   "index.obj",  "nan.obj",   "flat.obj",      "points.obj",
                                   "scene.xyz",       "index.gltf", "nan.gltf",  "inf.gltf",      "zero.gltf"})
        expect_refused("lumenfarm", {{"run", "@/" + file, "-o", "@/out"}, 2, file});
    expect_all_refused({{{"run", "@", "-o", "@/out"}, 2, "@"},
                        {{"run", "/dev/null", "-o", "@/out"}, 2, "/dev/null"},
                        {{"run", "@/unlit.gltf", "-o", "@/out"}, 2, "--light"},
                        {{"run", "@/garbage.lfscene", "--light", "-o", "@/out"}, 2, "--light"},
                        {{"submit", "@/unlit.gltf"}, 2, "--light"}});
}

TEST_F(BadInput, UnwritableOutput) {
    write_lit_scene();
    folder_.write("file", "x");
    expect_all_refused({{{"run", "@/lit.gltf", "-o", "@/file"}, 1, "@/file"},
                        {{"run", "@/lit.gltf", "-o", "@/file/out"}, 1, "@/file/out"},
                        {{"run", "@/lit.gltf", "-o", "/proc/out"}, 1, "/proc/out"},
                        {{"fetch", "1", "-o", "@/file"}, 1, "@/file"}});
}

TEST_F(BadInput, Results) {
    JobSpec spec;
    spec.particles = 1'000;
    const LoadedRun run = test::traced_run(mixed_room(), spec);
    ASSERT_TRUE(save_run(folder_ / "good", encode_scene(run.scene), run.solution));
    namespace fs = std::filesystem;
    for (const char* name : {"empty", "garbage", "cut", "alone", "other"}) fs::create_directory(folder_ / name);
    for (const char* name : {"garbage", "cut"}) fs::copy(folder_ / "good/scene.lfscene", folder_ / name);
    folder_.write("garbage/solution.lfs", std::string(500, 'x'));
    fs::copy(folder_ / "good/solution.lfs", folder_ / "cut");
    fs::resize_file(folder_ / "cut/solution.lfs", fs::file_size(folder_ / "cut/solution.lfs") / 2);
    fs::copy(folder_ / "good/solution.lfs", folder_ / "alone");
    Scene other = run.scene;
    other.lights.front().photometric *= 2;
    const auto other_bytes = encode_scene(other);
    folder_.write("other/scene.lfscene", {reinterpret_cast<const char*>(other_bytes.data()), other_bytes.size()});
    fs::copy_file(folder_ / "good/solution.lfs", folder_ / "other/solution.lfs");
    folder_.write("points.csv", "0.5,0.5,0\n");
    folder_.write("nan.csv", "0,0,nan\n");
    folder_.write("two.csv", "0,0\n");
    const auto render = [](std::vector<std::string> options, const std::string& says, int status = 2) {
        Case bad{{"render", "@/good"}, status, says};
        bad.arguments.insert(bad.arguments.end(), options.begin(), options.end());
        return bad;
    };
    expect_all_refused({
        {{"inspect", "@/missing"}, 2, "@/missing"},
        {{"inspect", "@/empty"}, 2, "@/empty"},
        {{"inspect", "@/garbage"}, 2, "@/garbage"},
        {{"inspect", "@/cut"}, 2, "@/cut"},
        {{"inspect", "@/alone"}, 2, "@/alone/scene.lfscene"},
        {{"inspect", "@/other"}, 2, "@/other"},
        {{"inspect", "@/points.csv"}, 2, "@/points.csv"},
        {{"measure", "@/good", "--points", "@/gone.csv", "-o", "@/out"}, 2, "@/gone.csv"},
        {{"measure", "@/good", "--points", "@/nan.csv", "-o", "@/out"}, 2, "nan"},
        {{"measure", "@/good", "--points", "@/two.csv", "-o", "@/out"}, 2, "@/two.csv"},
        {{"measure", "@/good", "--points", "@/points.csv", "-o", "@/gone/lux.csv"}, 1, "@/gone/lux.csv"},
        {{"measure", "@/missing", "--points", "@/points.csv", "-o", "@/out"}, 2, "@/missing"},
        render({"-o", "@/view.jpg"}, "@/view.jpg"),
        render({"-o", "@/gone/view.exr"}, "@/gone/view.exr", 1),
        render({"-o", "@/view.exr", "--camera", "nobody"}, "nobody"),
        render({"-o", "@/view.exr", "--look-from", "0,0,1"}, "look"),
        render({"-o", "@/view.exr", "--look-from", "0,0,1", "--look-at", "0,0,1"}, "look"),
        render({"-o", "@/view.exr", "--look-from", "0,0", "--look-at", "0,0,1"}, "'0,0'"),
        render({"-o", "@/view.exr", "--fov", "0"}, "--fov"),
        render({"-o", "@/view.exr", "--fov", "180"}, "--fov"),
        render({"-o", "@/view.exr", "--fov", "wide"}, "wide"),
        render({"-o", "@/view.exr", "--size", "0x0"}, "0x0"),
        render({"-o", "@/view.exr", "--size", "large"}, "large"),
        render({"-o", "@/view.exr", "--size", "99999x99999"}, "99999x99999"),
        render({"-o", "@/view.exr", "--samples", "0"}, "--samples"),
    });
    EXPECT_FALSE(fs::exists(folder_ / "view.exr"));
}

TEST_F(BadInput, MasterThatIsNotThere) {
    write_lit_scene();
    std::string nobody;
    {
        const SilentListener gone;
        nobody = gone.address();
    }
    for (const auto& command : std::vector<std::vector<std::string>>{{"status"},
                                                                     {"workers", "--json"},
                                                                     {"watch", "1"},
                                                                     {"cancel", "1"},
                                                                     {"fetch", "1", "-o", "@/out"},
                                                                     {"submit", "@/lit.gltf"}}) {
        Case bad{command, 1, nobody};
        bad.arguments.insert(bad.arguments.end(), {"--master", nobody});
        expect_refused("lumenfarm", bad);
    }
    const SilentListener silent;
    expect_all_refused({{{"status", "--master", silent.address()}, 1, silent.address()},
                        {{"status", "--master", "nowhere"}, 2, "'nowhere'"},
                        {{"status", "--master", "127.0.0.1:99999"}, 2, "127.0.0.1:99999"},
                        {{"status", "--master", "127.0.0.1:0"}, 2, "127.0.0.1:0"},
                        {{"status", "--master", "no.such.host.invalid:7420"}, 1, "no.such.host.invalid"},
                        {{"status", "first"}, 2, "'first'"},
                        {{"watch", "0"}, 2, "'0'"},
                        {{"cancel", "-1"}, 2, "-1"},
                        {{"fetch", "1"}, 2, "--output"}});
}

TEST_F(BadInput, MasterThatKnowsBetter) {
    write_lit_scene();
    Process master({program("lumenfarm-master"), "--listen", "127.0.0.1:0", "--storage", at_home("@/store")});
    std::string address;
    ASSERT_TRUE(master.read_until([&] {
        const auto at = master.err().find("listening on ");
        const auto end = at == std::string::npos ? at : master.err().find_first_of(",\n", at);
        if (end != std::string::npos) address = master.err().substr(at + 13, end - at - 13);
        return !address.empty();
    })) << master.err();
    Process submit({program("lumenfarm"), "submit", at_home("@/lit.gltf"), "--master", address});
    ASSERT_EQ(submit.wait(), 0) << submit.err();
    expect_all_refused({{{"status", "99", "--master", address}, 2, "99"},
                        {{"watch", "99", "--master", address}, 2, "99"},
                        {{"cancel", "99", "--master", address}, 2, "99"},
                        {{"fetch", "99", "-o", "@/out", "--master", address}, 2, "99"},
                        {{"fetch", "1", "-o", "@/out", "--master", address}, 1, "1"},
                        {{"submit", "@/lit.gltf", "--texel", "1e8", "--master", address}, 2, "texel"}});
    expect_refused("lumenfarm-master", {{"--listen", address, "--storage", "@/store2"}, 1, address});
    expect_refused("lumenfarm-master", {{"--listen", "127.0.0.1:0", "--storage", "@/store"}, 1, "@/store"});
    master.send(SIGTERM);
    EXPECT_EQ(master.wait(), 0) << master.err();
}

TEST_F(BadInput, Daemons) {
    folder_.write("file", "x");
    for (const Case& bad : std::vector<Case>{
             {{"--listen", "127.0.0.1:0"}, 2, "--storage"},
             {{"--listen", "nowhere", "--storage", "@/store"}, 2, "nowhere"},
             {{"--listen", "0.0.0.0:0", "--storage", "@/store"}, 2, "--allow-plaintext"},
             {{"--listen", "127.0.0.1:0", "--storage", "@/file"}, 1, "@/file"},
             {{"--listen", "127.0.0.1:0", "--storage", "@/store", "--set-seconds", "-1"}, 2, "--set-seconds"},
             {{"--listen", "127.0.0.1:0", "--storage", "@/store", "--results-in-flight", "0"},
              2,
              "--results-in-flight"},
             {{"--storage", "@/store", "--sing"}, 2, "--sing"}})
        expect_refused("lumenfarm-master", bad);
    for (const Case& bad : std::vector<Case>{{{"--master", "nowhere"}, 2, "nowhere"},
                                             {{"--threads", "-1"}, 2, "threads"},
                                             {{"--threads", "1e6"}, 2, "threads"},
                                             {{"--isa", "sse9"}, 2, "sse9"},
                                             {{"--cache-bytes", "lots"}, 2, "cache-bytes"}})
        expect_refused("lumenfarm-worker", bad);
}

}  // namespace
}  // namespace lumenfarm::testing
