// False colours: sRGB at 51 equal steps from the smallest number to the largest, straight lines between them.
//
// viridis and inferno: Nathaniel Smith and Stéfan van der Walt (2015), CC0; equal steps look equally large. turbo: Anton
// Mikhailov (Google, 2019), Apache-2.0; a rainbow whose steps are smooth, for finding small differences. blue to red:
// RdBu of Cynthia Brewer's ColorBrewer, Apache-2.0; for numbers around 0. Matplotlib's tables, sampled.

export const STEPS = 51;

export const MAPS = {
  viridis: {
    name: "Viridis",
    digits:
      "44015446085c47106348176a481e70482575472b7a46317e453882433e854144873e49893c4f8b39558c375a8c345f8d32648e" +
      "30698e2e6e8e2c738e2a788e287d8e26828e24878e228b8d21908c1f958b1f9a8a1f9e8820a38622a88426ad812cb17e33b67a" +
      "3aba7643bf714dc36c57c76662ca5f6ece587ad15186d54993d741a1da38aedc30bcdf27c9e01fd7e21ae4e419f1e51dfde725",
  },
  inferno: {
    name: "Inferno",
    digits:
      "00000402020c0504170a0722100a2e170b3b1f0c47270b52300a5c390963420a684a0c6b530e6d5b116e63146e6b176e731a6e" +
      "7b1d6d83206b8b23699326679c2964a42c61ab2f5db33359bb3755c23b50c9404bd04545d74b3fdd513ae25734e75f2dec6627" +
      "f06e21f3771af67f13f8880dfa9207fb9b06fca50afcae13fbb81dfac229f8cc36f6d644f4e055f2e968f2f27cf5f991fcffa4",
  },
  turbo: {
    name: "Turbo",
    digits:
      "30123b3621603b3081403e9e434cb7455acd4668df4775ed4682f8448efe3e9bfe36a8fa2db5f125c1e61dccd919d6cc18dfbe" +
      "1de7b227eda535f39546f8845afb726efe6282ff5394fe46a3fd3cb0f937bef434caed34d6e635e1dd37ebd339f3c93af8be39" +
      "fcb236fea531fe972cfd8825fa781ef56918f05b12e94e0de24209d93807cf2e04c42503b81d02aa16019c0f018c09027a0403",
  },
  rdbu: {
    name: "Blue to red",
    digits:
      "0530610a3b7010457f15508d1b5a9c2065ab276eb02e77b53581b93c8abe4393c3529dc862a7cd71b0d381bad890c4dd9dcbe1" +
      "aad1e5b7d8e8c4deecd1e5f0d9e8f1e0ecf2e8eff4eff3f5f7f6f6f8f1edf9ebe3fbe6dafce0d0fddbc7fbd0b9f9c5abf7ba9d" +
      "f5af8ff3a481ed9677e7896ce27b62dc6e57d6604dcf5246c7433fc03539b82632b1182ba21329930e26850a2476052167001f",
  },
};

// {r, g, b} one after another, 0 to 1, for a shader.
export const tableOf = (map) => Float32Array.from(MAPS[map].digits.match(/../g), (digits) => parseInt(digits, 16) / 255);

// The same as a background.
export const gradientOf = (map, towards) =>
  `linear-gradient(${towards}, ${MAPS[map].digits.match(/.{6}/g).map((digits) => `#${digits}`).join(", ")})`;
