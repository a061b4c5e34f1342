// three.js as `vendor.js` defines it, which stands before this script in each page.
export const {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  DoubleSide,
  LinearFilter,
  LineSegments,
  Mesh,
  OrbitControls,
  PerspectiveCamera,
  Scene,
  ShaderMaterial,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderer,
} = globalThis.DolfingripThree;
