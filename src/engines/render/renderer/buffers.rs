//! Buffers that are written anew for each picture.

/// A buffer that grows with what is written into it.
pub struct GrowingBuffer {
    buffer: wgpu::Buffer,
    usage: wgpu::BufferUsages,
}

impl GrowingBuffer {
    /// A small one.
    pub fn new(device: &wgpu::Device, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self { buffer: buffer(device, 1024, usage), usage }
    }

    /// Writes `bytes`; says whether the buffer is another one than before.
    pub fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> bool {
        let grows = bytes.len() as u64 > self.buffer.size();
        if grows {
            self.buffer = buffer(device, (bytes.len() as u64).next_power_of_two(), self.usage);
        }
        if !bytes.is_empty() {
            queue.write_buffer(&self.buffer, 0, bytes);
        }
        grows
    }

    /// The buffer as it is now.
    pub fn get(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

/// The bytes of `items`, each starting at a multiple of `stride`.
pub fn spaced<T: bytemuck::Pod>(items: impl IntoIterator<Item = T>, stride: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for item in items {
        let start = bytes.len();
        bytes.extend_from_slice(bytemuck::bytes_of(&item));
        bytes.resize(start + stride, 0);
    }
    bytes
}

fn buffer(device: &wgpu::Device, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some("picture"), size, usage, mapped_at_creation: false })
}
