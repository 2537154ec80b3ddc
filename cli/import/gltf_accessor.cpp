#include "cli/import/gltf_accessor.h"

#include "common/support/limits.h"

#include <algorithm>
#include <cstring>

namespace lumenfarm::import {
namespace {

/// Elements of one type that lie in bytes with a stride.
struct Run {
    std::span<const std::byte> bytes;
    std::size_t stride = 0;
    std::size_t count = 0;
    int component_type = 0;
    int components = 0;
    bool normalized = false;
};

std::string accessor_name(int index) { return "accessor " + std::to_string(index); }

template <class T>
double component(const std::byte* at, bool normalized) {
    T value{};
    std::memcpy(&value, at, sizeof value);
    if constexpr (std::is_integral_v<T>) {
        if (normalized) return std::max(-1.0, double(value) / double(std::numeric_limits<T>::max()));
    }
    return static_cast<double>(value);
}

double component_at(const Run& run, std::size_t element, int index) {
    const auto size = static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(std::uint32_t(run.component_type)));
    const std::byte* at = run.bytes.data() + element * run.stride + static_cast<std::size_t>(index) * size;
    switch (run.component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE: return component<std::int8_t>(at, run.normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return component<std::uint8_t>(at, run.normalized);
        case TINYGLTF_COMPONENT_TYPE_SHORT: return component<std::int16_t>(at, run.normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return component<std::uint16_t>(at, run.normalized);
        case TINYGLTF_COMPONENT_TYPE_INT: return component<std::int32_t>(at, run.normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return component<std::uint32_t>(at, run.normalized);
        case TINYGLTF_COMPONENT_TYPE_DOUBLE: return component<double>(at, run.normalized);
        default: return component<float>(at, run.normalized);
    }
}

/// Completes `run` with bytes of a view from an offset on. Errors: bad_input when it leaves the view.
Result<Run> place(const tinygltf::Model& model, int view, std::uint64_t offset, Run run, const std::string& who,
                  const SceneBuilder& builder) {
    const auto bytes = view_bytes(model, view, builder);
    if (!bytes) return bytes.error();
    const int size = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(run.component_type));
    if (size <= 0 || run.components <= 0)
        return builder.refuse(who + " has the unknown component type " + std::to_string(run.component_type));
    const std::size_t element = static_cast<std::size_t>(size) * static_cast<std::size_t>(run.components);
    const std::size_t stride = model.bufferViews[static_cast<std::size_t>(view)].byteStride;
    run.stride = stride == 0 ? element : stride;
    const std::size_t room = offset <= bytes->size() ? bytes->size() - offset : 0;
    if (run.count > 0 && (room < element || (run.count - 1) > (room - element) / run.stride))
        return builder.refuse(who + " has " + std::to_string(run.count) + " elements from byte " +
                              std::to_string(offset) + ", more than its buffer view of " +
                              std::to_string(bytes->size()) + " bytes holds");
    run.bytes = bytes->subspan(std::min<std::size_t>(offset, bytes->size()));
    return run;
}

Result<const tinygltf::Accessor*> find_accessor(const tinygltf::Model& model, int index, int components,
                                                const SceneBuilder& builder) {
    if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size())
        return builder.refuse(accessor_name(index) + " does not exist; there are " +
                              std::to_string(model.accessors.size()));
    const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(index)];
    if (tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type)) != components)
        return builder.refuse(accessor_name(index) + " must have " + std::to_string(components) +
                              " components an element");
    std::uint64_t bytes = 0;
    for (const tinygltf::Buffer& buffer : model.buffers) bytes += buffer.data.size();
    if (a.count == 0 || a.count > bytes || a.count > limits::vertices_max)
        return builder.refuse(accessor_name(index) + " has the count " + std::to_string(a.count) +
                              ", but the file's buffers have " + std::to_string(bytes) + " bytes");
    return &a;
}

/// Replaces the elements that a sparse accessor lists.
Result<void> apply_sparse(const tinygltf::Model& model, const tinygltf::Accessor& a, const std::string& who,
                          const SceneBuilder& builder, std::vector<double>& numbers, int components) {
    const auto& s = a.sparse;
    if (s.count <= 0 || static_cast<std::size_t>(s.count) > a.count || s.indices.byteOffset < 0 ||
        s.values.byteOffset < 0)
        return builder.refuse(who + " has " + std::to_string(s.count) + " sparse elements of " +
                              std::to_string(a.count));
    const Run shape{{}, 0, static_cast<std::size_t>(s.count), s.indices.componentType, 1, false};
    const auto indices = place(model, s.indices.bufferView, static_cast<std::uint64_t>(s.indices.byteOffset), shape,
                               who + " (sparse indices)", builder);
    if (!indices) return indices.error();
    const Run form{{}, 0, static_cast<std::size_t>(s.count), a.componentType, components, a.normalized};
    const auto values = place(model, s.values.bufferView, static_cast<std::uint64_t>(s.values.byteOffset), form,
                              who + " (sparse values)", builder);
    if (!values) return values.error();
    for (std::size_t i = 0; i < shape.count; ++i) {
        const double target = component_at(*indices, i, 0);
        if (!(target >= 0 && target < static_cast<double>(a.count)))
            return builder.refuse(who + " has the sparse index " + std::to_string(target) + " of " +
                                  std::to_string(a.count));
        const std::size_t first = static_cast<std::size_t>(target) * static_cast<std::size_t>(components);
        for (int c = 0; c < components; ++c) numbers[first + std::size_t(c)] = component_at(*values, i, c);
    }
    return {};
}

}  // namespace

Result<std::vector<double>> read_numbers(const tinygltf::Model& model, int accessor, int components,
                                         const SceneBuilder& builder) {
    const auto found = find_accessor(model, accessor, components, builder);
    if (!found) return found.error();
    const tinygltf::Accessor& a = **found;
    const std::string who = accessor_name(accessor);
    std::vector<double> numbers;
    if (a.bufferView >= 0) {
        const Run form{{}, 0, a.count, a.componentType, components, a.normalized};
        const auto run = place(model, a.bufferView, a.byteOffset, form, who, builder);
        if (!run) return run.error();
        numbers.reserve(a.count * static_cast<std::size_t>(components));
        for (std::size_t i = 0; i < a.count; ++i)
            for (int c = 0; c < components; ++c) numbers.push_back(component_at(*run, i, c));
    } else if (a.sparse.isSparse) {
        numbers.resize(a.count * static_cast<std::size_t>(components));
    } else {
        return builder.refuse(who + " has neither a buffer view nor sparse values");
    }
    if (a.sparse.isSparse)
        if (auto sparse = apply_sparse(model, a, who, builder, numbers, components); !sparse) return sparse.error();
    return numbers;
}

Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int accessor,
                                                const SceneBuilder& builder) {
    const auto numbers = read_numbers(model, accessor, 1, builder);
    if (!numbers) return numbers.error();
    const int type = model.accessors[static_cast<std::size_t>(accessor)].componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        return builder.refuse(accessor_name(accessor) + " holds indices of the component type " + std::to_string(type) +
                              "; they must be unsigned integers");
    std::vector<std::uint32_t> indices(numbers->size());
    std::transform(numbers->begin(), numbers->end(), indices.begin(),
                   [](double value) { return static_cast<std::uint32_t>(value); });
    return indices;
}

}  // namespace lumenfarm::import
