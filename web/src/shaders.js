// One light, kept near 1, so that a surface has the colour of the legend.

export const VERTEX = `
attribute vec3 rest; attribute vec3 from; attribute vec3 to;
attribute vec3 normalFrom; attribute vec3 normalTo;
attribute float valueFrom; attribute float valueTo;
uniform vec3 uLow, uSize, uMirror; uniform float uPart;
varying vec3 vNormal, vPlace; varying float vValue, vRestY;
void main() {
  vRestY = uLow.y + uSize.y * rest.y;
  vec3 place = uMirror * (uLow + uSize * mix(from, to, uPart));
  vNormal = normalMatrix * (uMirror * mix(normalFrom, normalTo, uPart));
  vValue = mix(valueFrom, valueTo, uPart);
  vec4 seen = modelViewMatrix * vec4(place, 1.0);
  vPlace = seen.xyz;
  gl_Position = projectionMatrix * seen;
}`;

const CUT = `if (uCut > 0.5 && vRestY < -1.0e-4) discard;`;

export const SURFACE = `
uniform sampler2D uPalette; uniform vec2 uRange; uniform vec4 uFlat; uniform float uCut;
varying vec3 vNormal, vPlace; varying float vValue, vRestY;
void main() {
  ${CUT}
  vec3 n = normalize(vNormal), v = normalize(-vPlace);
  if (dot(n, v) < 0.0) n = -n;
  float share = clamp((vValue - uRange.x) / max(uRange.y - uRange.x, 1.0e-12), 0.0, 1.0);
  vec3 colour = texture2D(uPalette, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (uFlat.a > 0.0) colour = uFlat.rgb;
  float light = 0.5 + 0.5 * dot(n, normalize(vec3(0.35, 0.75, 0.65)));
  float rim = pow(1.0 - max(dot(n, v), 0.0), 4.0);
  vec3 lit = colour * (0.62 + 0.44 * light) * (1.0 - 0.15 * rim);
  gl_FragColor = vec4(lit, uFlat.a > 0.0 ? uFlat.a : 1.0);
}`;

export const LINE = `
uniform vec4 uFlat; uniform float uCut;
varying float vRestY;
void main() { ${CUT} gl_FragColor = uFlat; }`;
