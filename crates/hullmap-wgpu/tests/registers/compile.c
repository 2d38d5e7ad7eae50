// Creates a compute pipeline for each SPIR-V file, on the first Vulkan device. Nothing runs. Drivers
// that print statistics of what they compile do so, also Mesa's RADV without a device:
//
//   RADV_FORCE_FAMILY=navi21 RADV_DEBUG=shaderstats compile FOLDER/solve_pairs.spv...
//
// Each file is named for its entry point.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

#define BINDINGS 9

static void check(VkResult result, const char *what) {
    if (result != VK_SUCCESS) {
        fprintf(stderr, "%s: VkResult %d\n", what, result);
        exit(1);
    }
}

int main(int count, char **files) {
    VkInstance instance;
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_2};
    VkInstanceCreateInfo of_instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                        .pApplicationInfo = &application};
    check(vkCreateInstance(&of_instance, NULL, &instance), "vkCreateInstance");
    VkPhysicalDevice adapter;
    uint32_t one = 1;
    VkResult listed = vkEnumeratePhysicalDevices(instance, &one, &adapter);
    check(listed == VK_INCOMPLETE ? VK_SUCCESS : listed, "vkEnumeratePhysicalDevices");
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(adapter, &properties);
    printf("%s\n", properties.deviceName);
    float priority = 1.0f;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo of_device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .queueCreateInfoCount = 1,
                                    .pQueueCreateInfos = &queue};
    VkDevice device;
    check(vkCreateDevice(adapter, &of_device, NULL, &device), "vkCreateDevice");

    VkDescriptorSetLayoutBinding bindings[BINDINGS];
    for (uint32_t at = 0; at < BINDINGS; at++) {
        bindings[at] = (VkDescriptorSetLayoutBinding){
            .binding = at,
            .descriptorType = at == 0 ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
            .descriptorCount = 1,
            .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    }
    VkDescriptorSetLayoutCreateInfo of_set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                              .bindingCount = BINDINGS, .pBindings = bindings};
    VkDescriptorSetLayout set;
    check(vkCreateDescriptorSetLayout(device, &of_set, NULL, &set), "vkCreateDescriptorSetLayout");
    VkPipelineLayoutCreateInfo of_layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                            .setLayoutCount = 1, .pSetLayouts = &set};
    VkPipelineLayout layout;
    check(vkCreatePipelineLayout(device, &of_layout, NULL, &layout), "vkCreatePipelineLayout");

    static uint32_t code[1 << 18];
    for (int at = 1; at < count; at++) {
        FILE *file = fopen(files[at], "rb");
        if (!file) {
            perror(files[at]);
            return 1;
        }
        size_t size = fread(code, 1, sizeof code, file);
        fclose(file);
        VkShaderModuleCreateInfo of_module = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                              .codeSize = size, .pCode = code};
        VkShaderModule module;
        check(vkCreateShaderModule(device, &of_module, NULL, &module), files[at]);
        char name[256];
        const char *slash = strrchr(files[at], '/');
        snprintf(name, sizeof name, "%s", slash ? slash + 1 : files[at]);
        *strrchr(name, '.') = 0;
        printf("\n== %s\n", name);
        fflush(stdout);
        VkComputePipelineCreateInfo of_pipeline = {
            .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
            .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                      .stage = VK_SHADER_STAGE_COMPUTE_BIT, .module = module, .pName = name},
            .layout = layout};
        VkPipeline pipeline;
        check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &of_pipeline, NULL, &pipeline), name);
    }
    return 0;
}
